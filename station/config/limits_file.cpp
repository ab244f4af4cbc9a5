// SPDX-License-Identifier: Apache-2.0
#include "station/config/limits_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "calib/vocabulary/sensor.h"

namespace soak::station {
namespace {

using PerSensor = std::array<std::optional<double>, calib::kSensorCount>;

constexpr settings::Limits kPositive = {1e-12, 1e9};
constexpr std::string_view kScaleSuffix = "_scale_ppm";

std::string_view all_axes(calib::Sensor sensor) { return calib::is_gyro(sensor) ? "gyro" : "accel"; }

/// The limits of all sensors whose keys end in `suffix`, as they stand there.
PerSensor read_keys(const settings::Table& table, std::string_view suffix) {
  PerSensor limits;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto common = table.optional_number(fmt::format("{}{}", all_axes(sensor), suffix), kPositive);
    const auto own = table.optional_number(fmt::format("{}{}", calib::name_of(sensor), suffix), kPositive);
    limits[calib::index_of(sensor)] = own ? own : common;
  }
  return limits;
}

/// Names the keys that there are beside each that there is not.
void refuse_unknown(const settings::Table& table) {
  for (const std::string& key : table.keys()) {
    std::string_view stem = key;
    if (stem.ends_with(kScaleSuffix)) stem.remove_suffix(kScaleSuffix.size());
    if (stem == "gyro" || stem == "accel" || calib::sensor_named(stem)) continue;
    table.refuse(key, fmt::format("unknown limit '{}'; known: gyro, accel, gyro_x, gyro_y, gyro_z, accel_x, accel_y, "
                                  "accel_z (deg/s, m/s2), and each with {} behind it",
                                  key, kScaleSuffix));
  }
}

}  // namespace

calib::Limits read_limits_table(const settings::Table& table) {
  calib::Limits limits;
  limits.bias = read_keys(table, "");
  limits.scale_ppm = read_keys(table, kScaleSuffix);
  for (const calib::Sensor sensor : calib::kSensors) {
    if (auto& limit = limits.bias[calib::index_of(sensor)]) *limit /= calib::printed_per_si(sensor);
  }
  refuse_unknown(table);
  return limits;
}

base::Result<calib::Limits> read_limits(const std::filesystem::path& path) {
  return settings::read_file(path.string(), [](const settings::Table& root) {
    return read_limits_table(root.section("limits", settings::kRequired));
  });
}

std::map<std::string, double> stated_limits(const calib::Limits& limits) {
  std::map<std::string, double> stated;
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    const std::string name(calib::name_of(sensor));
    if (limits.bias[s]) stated[name] = *limits.bias[s] * calib::printed_per_si(sensor);
    if (limits.scale_ppm[s]) stated[name + std::string(kScaleSuffix)] = *limits.scale_ppm[s];
  }
  return stated;
}

}  // namespace soak::station
