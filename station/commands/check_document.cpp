// SPDX-License-Identifier: Apache-2.0
#include "station/commands/check_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "station/output.h"

namespace soak::station {
namespace {

using calib::ControlVerdict;
using calib::Estimate;
using calib::Sensor;
using nlohmann::json;

/// NAME and NAME_se in printed units; null where there is none.
void put(json& document, const std::string& name, const std::optional<Estimate>& estimate, double factor) {
  document[name] = estimate ? json(estimate->value * factor) : json();
  document[name + "_se"] = estimate ? json(estimate->standard_error * factor) : json();
}

json limits_document(const calib::ControlLimits& limits, double factor) {
  return {{"campaigns", limits.values},     {"centre", limits.centre * factor},
          {"lower", limits.lower * factor}, {"upper", limits.upper * factor},
          {"sigma", limits.sigma * factor}, {"moving_range_upper", limits.moving_range_upper * factor}};
}

json point_document(const CheckSensor& sensor, double factor) {
  const calib::ControlPoint& point = sensor.point;
  json document = {{"verdict", calib::name_of(point.verdict)},
                   {"beyond_limits", point.beyond_limits},
                   {"run_of_eight", point.run},
                   {"limits", point.limits ? limits_document(*point.limits, factor) : json()},
                   {"moving_range", point.moving_range ? json(*point.moving_range * factor) : json()}};
  put(document, "bias", sensor.bias, factor);
  put(document, "drift", sensor.drift, factor);
  return document;
}

json run_document(const CheckRun& run) {
  json sensors = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& reference = run.reference.sensor[calib::index_of(sensor)];
    if (!reference) continue;
    const double factor = calib::printed_per_si(sensor);
    json& document = sensors[std::string(calib::name_of(sensor))] = {{"temp_c", reference->temp_c}};
    put(document, "bias", reference->bias, factor);
    put(document, "first", reference->first, factor);
    put(document, "last", reference->last, factor);
    put(document, "drift", reference->drift, factor);
  }
  return {{"run", run.label},
          {"at_both_ends", run.reference.at_both_ends},
          {"visits", run.reference.visits},
          {"sensors", std::move(sensors)}};
}

json campaign_document(const CheckCampaign& campaign) {
  json sensors = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& charted = campaign.sensor[calib::index_of(sensor)];
    if (charted) {
      sensors[std::string(calib::name_of(sensor))] = point_document(*charted, calib::printed_per_si(sensor));
    }
  }
  json runs = json::array();
  for (const CheckRun& run : campaign.runs) runs.push_back(run_document(run));
  return {{"campaign", campaign.name},       {"created_utc_s", campaign.created_utc_s},
          {"simulated", campaign.simulated}, {"verdict", calib::name_of(campaign.verdict)},
          {"sensors", std::move(sensors)},   {"runs", std::move(runs)}};
}

json chart_document(const CheckChart& chart) {
  json temps = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& temp_c = chart.temp_c[calib::index_of(sensor)];
    if (temp_c) temps[std::string(calib::name_of(sensor))] = *temp_c;
  }
  json campaigns = json::array();
  for (const CheckCampaign& campaign : chart.campaigns) campaigns.push_back(campaign_document(campaign));
  return {{"unit", chart.unit},
          {"epoch", chart.epoch},
          {"ended", chart.ended.has_value()},
          {"temp_c", std::move(temps)},
          {"campaigns", std::move(campaigns)}};
}

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
  if (point.beyond_limits) text += ", beyond 3 sigma";
  if (point.run) text += ", eight on one side";
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

json check_document(const std::vector<CheckChart>& charts) {
  json units = json::array();
  for (const CheckChart& chart : charts) units.push_back(chart_document(chart));
  return {{"reference_c", calib::kReferencePlateau_c}, {"units", std::move(units)}};
}

std::string check_text(const std::vector<CheckChart>& charts) {
  std::string text;
  for (const CheckChart& chart : charts) text += (text.empty() ? "" : "\n") + chart_text(chart);
  return text;
}

}  // namespace soak::station
