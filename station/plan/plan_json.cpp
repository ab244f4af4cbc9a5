// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "station/io/output.h"
#include "station/plan/campaign_plan.h"

namespace soak::station {
namespace {

using calib::kSensors;
using calib::Sensor;

nlohmann::json picture_json(const TypePicture& picture) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const auto& known = picture.sensors[index_of(sensor)];
    if (!known) continue;
    const double per_si = printed_per_si(sensor);
    sensors[std::string(name_of(sensor))] = {
        {"scale", known->scale * per_si},
        {"length_c", known->length_c},
        {"smoothness", known->smoothness == calib::Smoothness::once ? "once" : "twice"},
        {"half_gap", known->half_gap * per_si},
        {"run_to_run", known->run_to_run * per_si},
        {"visit", known->visit * per_si},
        {"noise", known->noise * per_si},
        {"dwell_s", known->dwell_s}};
  }
  return {{"source", picture.units.empty() ? "type" : "units"},
          {"units", picture.units},
          {"simulated", picture.simulated},
          {"temp_min_c", picture.low_c},
          {"temp_max_c", picture.high_c},
          {"sensors", sensors},
          {"remarks", picture.remarks}};
}

/// The widest bands of each sensor.
nlohmann::json widest_json(const PlanOption& option) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const auto& band = option.bands[index_of(sensor)];
    if (!band) continue;
    const double per_si = printed_per_si(sensor);
    sensors[std::string(name_of(sensor))] = {{"shape95", band->worst_shape() * per_si},
                                             {"curve95", band->worst_curve() * per_si},
                                             {"fresh95", band->worst_fresh() * per_si},
                                             {"level_sigma", band->level_sigma * per_si}};
  }
  return sensors;
}

nlohmann::json option_json(const PlanOption& option) {
  return {{"passes", option.design.passes},
          {"plateaus", option.design.plateaus},
          {"return_every", option.design.return_every},
          {"power_cycles", option.design.power_cycles},
          {"power_ons", option.power_ons},
          {"dwell_s", option.design.dwell_s},
          {"hours", option.hours},
          {"relative", option.relative},
          {"sensors", widest_json(option)}};
}

nlohmann::json bands_json(const PlanOption& option) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const auto& band = option.bands[index_of(sensor)];
    if (!band) continue;
    const double per_si = printed_per_si(sensor);
    nlohmann::json points = nlohmann::json::array();
    for (std::size_t i = 0; i < band->temp_c.size(); ++i) {
      points.push_back({{"temp_c", band->temp_c[i]},
                        {"shape95", band->shape95[i] * per_si},
                        {"curve95", band->curve95[i] * per_si},
                        {"fresh95", band->fresh95[i] * per_si}});
    }
    sensors[std::string(name_of(sensor))] = points;
  }
  return sensors;
}

}  // namespace

nlohmann::json plan_json(const CampaignPlan& plan, const TypePicture& picture, const std::string& type,
                         const PlanRequest& request) {
  const PlanOption& chosen = plan.options[plan.chosen];
  nlohmann::json options = nlohmann::json::array();
  for (const PlanOption& option : plan.options) options.push_back(option_json(option));
  const double gyro_per_si = printed_per_si(Sensor::gyro_x);
  return {{"type", type},
          {"picture", picture_json(picture)},
          {"accuracy",
           {{"gyro_dps", request.gyro ? number_or_null(*request.gyro * gyro_per_si) : nlohmann::json()},
            {"accel_mps2", number_or_null(request.accel)}}},
          {"hours_at_most", number_or_null(request.hours)},
          {"options", options},
          {"full", option_json(plan.full)},
          {"chosen", plan.chosen},
          {"reached", chosen.relative <= 1.0},
          {"bands", bands_json(chosen)}};
}

}  // namespace soak::station
