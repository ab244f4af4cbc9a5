// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/campaign_config.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "base/units.h"
#include "hal/sim/config/config_reader.h"

namespace soak::hal::sim {
namespace {

using Limits = ConfigReader::Limits;

constexpr Limits kTemperature_c = {-200.0, 300.0};
constexpr Limits kDuration_s = {1e-3, 1e7};
constexpr Limits kMagnitude = {0.0, 1e6};

Range scaled(Range range, double factor) { return {range.low * factor, range.high * factor}; }

void read_procedure(ConfigReader& reader, CampaignConfig& config) {
  config.seed = static_cast<std::uint64_t>(reader.whole("campaign.seed", {0.0, 9e18}));
  config.units = static_cast<int>(reader.whole("campaign.units", {1.0, kMaxUnits}));
  config.runs = static_cast<int>(reader.whole("campaign.runs", {1.0, kMaxRuns}));
  config.rows_per_position = static_cast<int>(reader.whole("campaign.rows_per_position", {1.0, kMaxRowsPerPosition}));
  config.row_interval_s = reader.number("campaign.row_interval_s", kDuration_s);
  config.start_c = reader.number("campaign.start_c", kTemperature_c);
  config.turn_c = reader.number("campaign.turn_c", kTemperature_c);
  config.step_c = reader.number("campaign.step_c", {0.01, 500.0});
  config.ramp_s = reader.number("campaign.ramp_s", kDuration_s);
  config.ramp_rows = static_cast<int>(reader.whole("campaign.ramp_rows", {0.0, 10000.0}));
  config.moving_rows = static_cast<int>(reader.whole("campaign.moving_rows", {0.0, 10000.0}));

  const double steps = (config.turn_c - config.start_c) / config.step_c;
  if (steps < 0.5) reader.refuse("campaign.turn_c", "'campaign.turn_c' must be above 'campaign.start_c'");
  if (std::abs(steps - std::round(steps)) > 1e-9) {
    reader.refuse("campaign.step_c", "'campaign.step_c' must divide the way from start_c to turn_c");
  }
}

void read_temperatures(ConfigReader& reader, CampaignConfig& config) {
  ThermometerMagnitudes& thermometer = config.thermometer;
  thermometer.settling_time_s = reader.number("thermometer.settling_time_s", kDuration_s);
  thermometer.visit_offset_half_width_c = reader.number("thermometer.visit_offset_half_width_c", kMagnitude);
  thermometer.plateau_drift_half_width_c = reader.number("thermometer.plateau_drift_half_width_c", kMagnitude);
  thermometer.noise_sigma_c = reader.number("thermometer.noise_sigma_c", kMagnitude);
  config.chamber.settling_time_s = reader.number("chamber.settling_time_s", kDuration_s);
  config.chamber.noise_sigma_c = reader.number("chamber.noise_sigma_c", kMagnitude);
}

void read_curve_shape(ConfigReader& reader, CampaignConfig& config) {
  CurveShape& curve = config.curve;
  curve.cold_c = config.start_c;
  curve.hot_c = config.turn_c;
  curve.arctan_centre_c = reader.range("curve.arctan_centre_c", kTemperature_c);
  curve.arctan_width_c = reader.range("curve.arctan_width_c", {0.1, 1e4});
  curve.activation_energy_ev = reader.range("curve.activation_energy_ev", {0.01, 2.0});
  curve.other_weight = reader.range("curve.other_weight", {0.0, 0.9});
  curve.feature_margin_c = reader.number("curve.feature_margin_c", kMagnitude);
  if (2.0 * curve.feature_margin_c > curve.hot_c - curve.cold_c) {
    reader.refuse("curve.feature_margin_c", "'curve.feature_margin_c' leaves no room between start_c and turn_c");
  }
}

/// What gyros and accelerometers have in common; `unit` is the suffix of their keys, `si` one of it in SI.
void read_sensor(ConfigReader& reader, const std::string& table, const std::string& unit, double si,
                 SensorMagnitudes& sensor) {
  const auto key = [&](const std::string& name) { return table + "." + name; };
  sensor.bias.span = scaled(reader.range(key("bias_span_" + unit), kMagnitude), si);
  sensor.bias.at_25c_half_width = si * reader.number(key("bias_at_25c_half_width_" + unit), kMagnitude);
  sensor.bias.feature_count = reader.whole_range(key("feature_count"), {0.0, 20.0});
  sensor.bias.feature_height = scaled(reader.range(key("feature_height_" + unit), kMagnitude), si);
  sensor.bias.feature_sigma_c = reader.range(key("feature_sigma_c"), {0.1, 1e3});
  sensor.power_on_sigma = si * reader.number(key("power_on_sigma_" + unit), kMagnitude);
  sensor.segment_mean_sigma = si * reader.number(key("segment_mean_sigma_" + unit), kMagnitude);
  sensor.misalignment_half_width_rad = reader.number(key("misalignment_half_width_rad"), {0.0, 0.2});
  if (sensor.bias.span.low <= sensor.bias.feature_count.high * sensor.bias.feature_height.high) {
    reader.refuse(key("bias_span_" + unit),
                  "'" + key("bias_span_" + unit) + "' must exceed its local features together");
  }
}

void read_site(ConfigReader& reader, CampaignConfig& config) {
  const auto latitude_deg = reader.optional_number("site.latitude_deg", {-90.0, 90.0});
  const auto azimuth_deg = reader.optional_number("site.azimuth_deg", {-360.0, 360.0});
  if (latitude_deg && azimuth_deg) config.earth = EarthFrame{*latitude_deg, *azimuth_deg};
  if (latitude_deg.has_value() != azimuth_deg.has_value()) {
    reader.refuse(latitude_deg ? "site.latitude_deg" : "site.azimuth_deg",
                  "'site.latitude_deg' and 'site.azimuth_deg' must be given together or not at all");
  }
}

}  // namespace

base::Result<CampaignConfig> parse_campaign_config(std::string_view text, const std::string& file) {
  ConfigReader reader(text, file);
  CampaignConfig config;
  read_procedure(reader, config);
  read_temperatures(reader, config);
  read_curve_shape(reader, config);
  read_sensor(reader, "gyro", "dps", base::kRadPerDeg, config.gyro);
  config.gyro.g_sensitivity =
      scaled(reader.range("gyro.g_sensitivity_dps_per_g", kMagnitude), base::kRadPerDeg / base::kStandardGravity_mps2);
  read_sensor(reader, "accel", "mps2", 1.0, config.accel);
  config.accel.scale_ppm.span = reader.range("accel.scale_span_ppm", kMagnitude);
  config.accel.scale_ppm.at_25c_half_width = reader.number("accel.scale_at_25c_half_width_ppm", kMagnitude);
  config.noise.slow_share = reader.number("noise.slow_share", {0.0, 1.0});
  config.noise.slow_correlation_times_s = reader.numbers("noise.slow_correlation_times_s", kDuration_s);
  read_site(reader, config);
  config.lab = read_lab_magnitudes(reader);
  config.design = read_design(reader);
  config.hidden = read_hidden(reader, "hidden");
  config.candidates = read_hidden(reader, "candidate");
  if (const base::Status status = reader.finish(); !status) return base::forward_error(status);
  return config;
}

base::Result<CampaignConfig> read_campaign_config(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return base::bad_input("cannot read this file; --config wants one in the format of lab.toml", file);
  const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  return parse_campaign_config(text, file);
}

}  // namespace soak::hal::sim
