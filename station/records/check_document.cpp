// SPDX-License-Identifier: Apache-2.0
#include "station/records/check_document.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace soak::station {
namespace {

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

json shift_document(const std::optional<calib::ControlShift>& shift, double factor) {
  if (!shift) return {};
  return {{"mean", shift->mean * factor},
          {"lower", shift->limits.lower * factor},
          {"upper", shift->limits.upper * factor},
          {"campaigns", shift->limits.values}};
}

json point_document(const CheckSensor& sensor, double factor) {
  const calib::ControlPoint& point = sensor.point;
  json document = {{"verdict", calib::name_of(point.verdict)},
                   {"beyond_limits", point.beyond_limits()},
                   {"shifted", point.shifted()},
                   {"last_eight", shift_document(point.shift, factor)},
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

}  // namespace

json check_document(const std::vector<CheckChart>& charts) {
  json units = json::array();
  for (const CheckChart& chart : charts) units.push_back(chart_document(chart));
  return {{"reference_c", calib::kReferencePlateau_c}, {"units", std::move(units)}};
}

}  // namespace soak::station
