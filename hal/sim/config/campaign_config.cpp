// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/campaign_config.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"

namespace soak::hal::sim {
namespace {

using settings::Limits;
using settings::Table;

constexpr Limits kCampaignDuration_s = {1e-3, 1e7};
/// Many times the shipped file with all effects hidden in it.
constexpr std::size_t kLongestConfig = 1U << 20U;

Range scaled_range(Range range, double factor) { return {range.low * factor, range.high * factor}; }

void read_procedure(const Table& campaign, CampaignConfig& config) {
  config.seed = static_cast<std::uint64_t>(campaign.large_whole("seed", {0.0, 9e18}));
  config.units = campaign.whole("units", {1.0, kMaxUnits});
  config.runs = campaign.whole("runs", {1.0, kMaxRuns});
  config.rows_per_position = campaign.whole("rows_per_position", {1.0, kMaxRowsPerPosition});
  config.row_interval_s = campaign.number("row_interval_s", kCampaignDuration_s);
  config.start_c = campaign.number("start_c", kAnyTemperature_c);
  config.turn_c = campaign.number("turn_c", kAnyTemperature_c);
  config.step_c = campaign.number("step_c", {0.01, 500.0});
  config.ramp_s = campaign.number("ramp_s", kCampaignDuration_s);
  config.ramp_rows = campaign.whole("ramp_rows", {0.0, 10000.0});
  config.moving_rows = campaign.whole("moving_rows", {0.0, 10000.0});

  const double steps = (config.turn_c - config.start_c) / config.step_c;
  if (!(steps >= 0.5)) {
    campaign.refuse("turn_c", "'campaign.turn_c' must be above 'campaign.start_c'");
  } else if (std::abs(steps - std::round(steps)) > 1e-9) {
    campaign.refuse("step_c", "'campaign.step_c' must divide the range from start_c to turn_c");
  }
}

void read_temperatures(const Table& root, CampaignConfig& config) {
  const Table thermometer = root.section("thermometer", settings::kRequired);
  config.thermometer.settling_time_s = thermometer.number("settling_time_s", kCampaignDuration_s);
  config.thermometer.visit_offset_half_width_c = thermometer.number("visit_offset_half_width_c", kAnyMagnitude);
  config.thermometer.plateau_drift_half_width_c = thermometer.number("plateau_drift_half_width_c", kAnyMagnitude);
  config.thermometer.noise_sigma_c = thermometer.number("noise_sigma_c", kAnyMagnitude);
  const Table chamber = root.section("chamber", settings::kRequired);
  config.chamber.settling_time_s = chamber.number("settling_time_s", kCampaignDuration_s);
  config.chamber.noise_sigma_c = chamber.number("noise_sigma_c", kAnyMagnitude);
}

void read_curve_shape(const Table& table, CampaignConfig& config) {
  CurveShape& curve = config.curve;
  curve.cold_c = config.start_c;
  curve.hot_c = config.turn_c;
  curve.arctan_centre_c = read_range(table, "arctan_centre_c", kAnyTemperature_c);
  curve.arctan_width_c = read_range(table, "arctan_width_c", {0.1, 1e4});
  curve.activation_energy_ev = read_range(table, "activation_energy_ev", {0.01, 2.0});
  curve.other_weight = read_range(table, "other_weight", {0.0, 0.9});
  curve.feature_margin_c = table.number("feature_margin_c", kAnyMagnitude);
  const double width_c = curve.hot_c - curve.cold_c;
  if (width_c > 0.0 && 2.0 * curve.feature_margin_c > width_c) {
    table.refuse("feature_margin_c", "'curve.feature_margin_c' leaves no room between start_c and turn_c");
  }
}

/// What gyros and accelerometers have in common; `unit` is the suffix of their keys, `si` one of it in SI.
void read_sensor(const Table& table, const std::string& unit, double si, SensorMagnitudes& sensor) {
  const std::string span = "bias_span_" + unit;
  sensor.bias.span = scaled_range(read_range(table, span, kAnyMagnitude), si);
  sensor.bias.at_25c_half_width = si * table.number("bias_at_25c_half_width_" + unit, kAnyMagnitude);
  sensor.bias.feature_count = read_whole_range(table, "feature_count", {0.0, 20.0});
  sensor.bias.feature_height = scaled_range(read_range(table, "feature_height_" + unit, kAnyMagnitude), si);
  sensor.bias.feature_sigma_c = read_range(table, "feature_sigma_c", {0.1, 1e3});
  sensor.power_on_sigma = si * table.number("power_on_sigma_" + unit, kAnyMagnitude);
  sensor.segment_mean_sigma = si * table.number("segment_mean_sigma_" + unit, kAnyMagnitude);
  sensor.misalignment_half_width_rad = table.number("misalignment_half_width_rad", {0.0, 0.2});
  if (sensor.bias.span.low <= sensor.bias.feature_count.high * sensor.bias.feature_height.high) {
    table.refuse(span, fmt::format("'{}' must exceed its local features together", span));
  }
}

void read_site(const Table& site, CampaignConfig& config) {
  const auto latitude_deg = site.optional_number("latitude_deg", {-90.0, 90.0});
  const auto azimuth_deg = site.optional_number("azimuth_deg", {-360.0, 360.0});
  if (latitude_deg && azimuth_deg) config.earth = EarthFrame{*latitude_deg, *azimuth_deg};
  if (latitude_deg.has_value() != azimuth_deg.has_value()) {
    site.refuse(latitude_deg ? "latitude_deg" : "azimuth_deg",
                "'site.latitude_deg' and 'site.azimuth_deg' must be given together or not at all");
  }
}

CampaignConfig read_config(const Table& root) {
  CampaignConfig config;
  read_procedure(root.section("campaign", settings::kRequired), config);
  read_temperatures(root, config);
  read_curve_shape(root.section("curve", settings::kRequired), config);
  const Table gyro = root.section("gyro", settings::kRequired);
  read_sensor(gyro, "dps", base::kRadPerDeg, config.gyro);
  config.gyro.g_sensitivity = scaled_range(read_range(gyro, "g_sensitivity_dps_per_g", kAnyMagnitude),
                                           base::kRadPerDeg / base::kStandardGravity_mps2);
  const Table accel = root.section("accel", settings::kRequired);
  read_sensor(accel, "mps2", 1.0, config.accel);
  config.accel.scale_ppm.span = read_range(accel, "scale_span_ppm", kAnyMagnitude);
  config.accel.scale_ppm.at_25c_half_width = accel.number("scale_at_25c_half_width_ppm", kAnyMagnitude);
  const Table noise = root.section("noise", settings::kRequired);
  config.noise.slow_share = noise.number("slow_share", {0.0, 1.0});
  config.noise.slow_correlation_times_s = read_some_numbers(noise, "slow_correlation_times_s", kCampaignDuration_s);
  read_site(root.section("site"), config);
  config.lab = read_lab_magnitudes(root);
  config.design = read_design(root);
  config.hidden = read_hidden(root, "hidden");
  config.candidates = read_hidden(root, "candidate");
  return config;
}

}  // namespace

Range read_range(const Table& table, std::string_view key, Limits limits) {
  const auto ends = table.numbers(key, limits, settings::kRequired);
  if (!table.has(key)) return {};
  if (ends.size() != 2) {
    table.refuse(key, fmt::format("'{}' must be a pair [low, high]", key));
    return {};
  }
  if (ends[0] > ends[1]) table.refuse(key, fmt::format("'{}' must have the lower value first", key));
  return {ends[0], ends[1]};
}

Range read_whole_range(const Table& table, std::string_view key, Limits limits) {
  const Range both = read_range(table, key, limits);
  if (both.low != std::floor(both.low) || both.high != std::floor(both.high)) {
    table.refuse(key, fmt::format("both values of '{}' must be whole numbers", key));
  }
  return both;
}

std::vector<double> read_some_numbers(const Table& table, std::string_view key, Limits limits) {
  auto numbers = table.numbers(key, limits, settings::kRequired);
  if (numbers.empty() && table.has(key)) table.refuse(key, fmt::format("'{}' must be a list of numbers", key));
  return numbers;
}

base::Result<CampaignConfig> parse_campaign_config(std::string_view text, const std::string& file) {
  return settings::read(text, file, read_config, kLongestConfig);
}

base::Result<CampaignConfig> read_campaign_config(const std::string& file) {
  const auto text = settings::read_text(file, kLongestConfig);
  if (!text) return base::bad_input("cannot read this file; --config needs one in the format of lab.toml", file);
  return parse_campaign_config(*text, file);
}

}  // namespace soak::hal::sim
