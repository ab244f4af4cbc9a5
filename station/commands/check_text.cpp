// SPDX-License-Identifier: Apache-2.0
#include "station/commands/check_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "station/io/output.h"

namespace soak::station {
namespace {

using calib::ControlVerdict;
using calib::Estimate;
using calib::Sensor;

std::string figure(double value) { return fmt::format("{:.5g}", value); }

std::string with_error(const std::optional<Estimate>& estimate, double factor) {
  if (!estimate) return "-";
  return fmt::format("{:.5g} ± {:.2g}", estimate->value * factor, estimate->standard_error * factor);
}

std::string_view words(ControlVerdict verdict) {
  return verdict == ControlVerdict::in_control       ? "in control"
         : verdict == ControlVerdict::out_of_control ? "OUT OF CONTROL"
                                                     : "not established";
}

std::string words(const calib::ControlPoint& point) {
  std::string text(words(point.verdict));
  if (point.beyond_limits()) text += ", beyond the limits";
  if (point.shifted()) text += ", the last eight have shifted";
  return text;
}

std::vector<std::string> point_row(const CheckCampaign& campaign, const CheckSensor& sensor, double factor) {
  const auto limit = [&](double calib::ControlLimits::* which) {
    return sensor.point.limits ? figure(*sensor.point.limits.*which * factor) : "-";
  };
  const auto range = sensor.point.moving_range;
  return {campaign.name,
          std::to_string(campaign.runs.size()),
          with_error(sensor.bias, factor),
          limit(&calib::ControlLimits::centre),
          limit(&calib::ControlLimits::lower),
          limit(&calib::ControlLimits::upper),
          range ? figure(*range * factor) : "-",
          limit(&calib::ControlLimits::moving_range_upper),
          with_error(sensor.drift, factor),
          words(sensor.point)};
}

std::string sensor_table(const CheckChart& chart, Sensor sensor) {
  const std::size_t s = calib::index_of(sensor);
  if (!chart.temp_c[s]) return {};
  std::vector<std::vector<std::string>> rows = {
      {"campaign", "runs", "bias", "centre", "lower", "upper", "range", "its limit", "in-run drift", "verdict"}};
  for (const CheckCampaign& campaign : chart.campaigns) {
    if (campaign.sensor[s]) rows.push_back(point_row(campaign, *campaign.sensor[s], calib::printed_per_si(sensor)));
  }
  return fmt::format("\n{}, {}, at {:.2f} °C of its thermometer\n{}", calib::name_of(sensor),
                     calib::printed_unit(sensor), *chart.temp_c[s], text_table(rows));
}

/// Campaigns of which nothing is on the charts.
std::string left_out(const CheckChart& chart) {
  std::vector<std::string> names;
  for (const CheckCampaign& campaign : chart.campaigns) {
    if (std::ranges::none_of(campaign.sensor, [](const auto& sensor) { return sensor.has_value(); })) {
      names.push_back(campaign.name);
    }
  }
  if (names.empty()) return {};
  return fmt::format("without a plateau within {:g} K of {:g} °C: {}\n", calib::kReferenceReach_c,
                     calib::kReferencePlateau_c, fmt::join(names, ", "));
}

std::string chart_text(const CheckChart& chart) {
  const bool simulated = std::ranges::any_of(chart.campaigns, &CheckCampaign::simulated);
  const ControlVerdict last =
      chart.campaigns.empty() ? ControlVerdict::not_established : chart.campaigns.back().verdict;
  std::string text = fmt::format("check standard {}, epoch {}{}{}: {} campaigns, the last one {}\n{}", chart.unit,
                                 chart.epoch, chart.ended ? " (ended)" : "", simulated ? " (SIMULATED)" : "",
                                 chart.campaigns.size(), words(last), left_out(chart));
  for (const Sensor sensor : calib::kSensors) text += sensor_table(chart, sensor);
  return text;
}

}  // namespace

std::string check_text(const std::vector<CheckChart>& charts) {
  std::string text;
  for (const CheckChart& chart : charts) text += (text.empty() ? "" : "\n") + chart_text(chart);
  return text;
}

}  // namespace soak::station
