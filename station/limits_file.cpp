// SPDX-License-Identifier: Apache-2.0
#include "station/limits_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>
#include <optional>
#include <string>

#include "station/csv/text_file.h"

namespace soak::station {
namespace {

constexpr std::string_view kKnown = "gyro, accel, gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z";

std::string place(const std::filesystem::path& path, const toml::source_region& source) {
  return fmt::format("{}, line {}", path.string(), source.begin.line);
}

/// Sets the limits that a key names; false where it names none. A key for one axis wins over one for all three.
bool set_limit(std::string_view key, double value, calib::Limits& all_axes, calib::Limits& one_axis) {
  bool known = false;
  for (const calib::Sensor sensor : calib::kSensors) {
    const double si = value / calib::printed_per_si(sensor);
    if (key == (calib::is_gyro(sensor) ? "gyro" : "accel")) {
      all_axes[calib::index_of(sensor)] = si;
      known = true;
    } else if (key == calib::name_of(sensor)) {
      one_axis[calib::index_of(sensor)] = si;
      known = true;
    }
  }
  return known;
}

}  // namespace

base::Result<calib::Limits> read_limits(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  toml::table root;
  try {
    root = toml::parse(*text);
  } catch (const toml::parse_error& error) {
    return base::bad_input(std::string(error.description()), place(path, error.source()));
  }
  for (const auto& [key, node] : root) {
    if (key.str() != "limits" || !node.is_table()) {
      return base::bad_input(fmt::format("unknown key '{}'; limits stand in a table [limits]", key.str()),
                             place(path, node.source()));
    }
  }
  const toml::table* table = root["limits"].as_table();
  if (table == nullptr) return base::bad_input("there is no table [limits]", path.string());
  calib::Limits all_axes;
  calib::Limits limits;
  for (const auto& [key, node] : *table) {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value) || *value <= 0.0) {
      return base::bad_input(
          fmt::format("'{}' must be a positive number (deg/s for gyros, m/s2 for accelerometers)", key.str()),
          place(path, node.source()));
    }
    if (!set_limit(key.str(), *value, all_axes, limits)) {
      return base::bad_input(fmt::format("unknown limit '{}'; known: {}", key.str(), kKnown),
                             place(path, node.source()));
    }
  }
  for (std::size_t s = 0; s < limits.size(); ++s) {
    if (!limits[s]) limits[s] = all_axes[s];
  }
  return limits;
}

}  // namespace soak::station
