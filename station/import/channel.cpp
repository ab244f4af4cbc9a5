// SPDX-License-Identifier: Apache-2.0
#include "station/import/channel.h"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "base/units.h"
#include "calib/vocabulary/sensor.h"

namespace soak::station {
namespace {

using base::bad_input;

struct FixedHeader {
  std::string_view header;
  ColumnRole role;
  std::string_view name;
  std::string_view unit;
  double scale = 1.0;
};

constexpr std::array<FixedHeader, 14> kFixedHeaders = {{
    {"t_s", ColumnRole::time, "t_s", "s"},
    {"t_ms", ColumnRole::time, "t_s", "s", 1e-3},
    {"t_us", ColumnRole::time, "t_s", "s", 1e-6},
    {"run", ColumnRole::run, "run", "label"},
    {"phase", ColumnRole::phase, "phase", "label"},
    {"sweep", ColumnRole::sweep, "sweep", "label"},
    {"position", ColumnRole::position, "position", "label"},
    {"rate_dps", ColumnRole::number, "rate_dps", "dps"},
    {"rate_rps", ColumnRole::number, "rate_dps", "rps"},
    {"turn_deg", ColumnRole::number, "turn_deg", "deg"},
    {"utc_s", ColumnRole::number, "utc_s", "s"},
    {"t_since_power_s", ColumnRole::number, "t_since_power_s", "s"},
    {"compressor", ColumnRole::number, "compressor", ""},
    {"supply_v", ColumnRole::number, "supply_v", "v"},
}};

constexpr std::array<std::string_view, calib::kSensorCount> kSensorHeaders = {"gx", "gy", "gz", "ax", "ay", "az"};
constexpr std::array<std::string_view, 3> kGyroUnits = {"dps", "rps", "degph"};
constexpr std::array<std::string_view, 3> kAccelUnits = {"mps2", "g", "mg"};
constexpr std::array<std::string_view, 3> kTemperatureUnits = {"c", "k", "f"};
constexpr std::array<std::string_view, 9> kTemperatures = {"temp",    "chamber", "plateau", "temp_gx", "temp_gy",
                                                           "temp_gz", "temp_ax", "temp_ay", "temp_az"};

bool contains(const std::array<std::string_view, 3>& units, std::string_view unit) {
  return units[0] == unit || units[1] == unit || units[2] == unit;
}

base::Result<std::optional<HeaderMeaning>> sensor_header(std::string_view header) {
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::string_view prefix = kSensorHeaders[calib::index_of(sensor)];
    const auto& units = calib::is_gyro(sensor) ? kGyroUnits : kAccelUnits;
    const bool ours = header == calib::name_of(sensor) || header == prefix ||
                      (header.starts_with(prefix) && header.substr(prefix.size()).starts_with('_'));
    if (!ours) continue;
    const std::string_view unit = header.starts_with(prefix) && header.size() > prefix.size() + 1
                                      ? header.substr(prefix.size() + 1)
                                      : std::string_view();
    if (!contains(units, unit)) {
      return bad_input(
          fmt::format("column '{0}' has no known unit: name it {1}_{2}, {1}_{3} or {1}_{4}, or map it with --columns",
                      header, prefix, units[0], units[1], units[2]));
    }
    return HeaderMeaning{ColumnRole::number, std::string(calib::name_of(sensor)), std::string(unit)};
  }
  return std::nullopt;
}

std::optional<HeaderMeaning> temperature_header(std::string_view header) {
  const std::size_t split = header.rfind('_');
  if (split == std::string_view::npos || !contains(kTemperatureUnits, header.substr(split + 1))) return std::nullopt;
  for (const std::string_view quantity : kTemperatures) {
    if (header.substr(0, split) != quantity) continue;
    return HeaderMeaning{ColumnRole::number, fmt::format("{}_c", quantity), std::string(header.substr(split + 1))};
  }
  return std::nullopt;
}

double same(double value) { return value; }
double rps_from_dps(double value) { return value * base::kRadPerDeg; }
double rps_from_degph(double value) { return value * base::kRadPerDeg / 3600.0; }
double dps_from_rps(double value) { return value * base::kDegPerRad; }
double dps_from_degph(double value) { return value / 3600.0; }
double mps2_from_g(double value) { return value * base::kStandardGravity_mps2; }
double mps2_from_mg(double value) { return value * base::kStandardGravity_mps2 / 1000.0; }
double celsius_from_kelvin(double value) { return value - base::kZeroCelsius_k; }
double celsius_from_fahrenheit(double value) { return (value - 32.0) / 1.8; }

Conversion common_conversion(std::string_view unit) {
  if (unit == "g") return mps2_from_g;
  if (unit == "mg") return mps2_from_mg;
  if (unit == "k") return celsius_from_kelvin;
  if (unit == "f") return celsius_from_fahrenheit;
  return same;
}

}  // namespace

base::Result<HeaderMeaning> meaning_of_header(std::string_view header) {
  for (const FixedHeader& fixed : kFixedHeaders) {
    if (fixed.header == header) {
      return HeaderMeaning{fixed.role, std::string(fixed.name), std::string(fixed.unit), fixed.scale};
    }
  }
  if (auto temperature = temperature_header(header)) return *std::move(temperature);
  auto sensor = sensor_header(header);
  if (!sensor) return base::forward_error(sensor);
  if (*sensor) return **std::move(sensor);
  return HeaderMeaning{ColumnRole::auxiliary, std::string(header), ""};
}

std::string canonical_header(std::string_view channel_name) {
  const auto sensor = calib::sensor_named(channel_name);
  if (!sensor) return std::string(channel_name);
  return fmt::format("{}_{}", kSensorHeaders[calib::index_of(*sensor)], calib::is_gyro(*sensor) ? "dps" : "mps2");
}

Conversion conversion_to_si(std::string_view unit) {
  if (unit == "dps") return rps_from_dps;
  if (unit == "degph") return rps_from_degph;
  return common_conversion(unit);
}

Conversion conversion_to_csv(std::string_view unit) {
  if (unit == "rps") return dps_from_rps;
  if (unit == "degph") return dps_from_degph;
  return common_conversion(unit);
}

}  // namespace soak::station
