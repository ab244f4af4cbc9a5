// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/chamber_time_json.h"

#include <nlohmann/json.hpp>

namespace soak::calib {
namespace {

using nlohmann::json;

json error_json(Sensor sensor, const ExpectedError& error) {
  const double factor = printed_per_si(sensor);
  return {{"rmse_shape", error.rmse_shape * factor},
          {"rmse_shape_high", error.rmse_shape_high * factor},
          {"error_rms", error.error_rms * factor},
          {"ci95", {error.error_low * factor, error.error_high * factor}},
          {"level_rms", error.level_rms * factor}};
}

json option_json(const ChamberTimeOption& option) {
  json sensors = json::object();
  for (const Sensor sensor : kSensors) {
    const auto& error = option.sensors[index_of(sensor)];
    if (error) sensors[std::string(name_of(sensor))] = error_json(sensor, *error);
  }
  return {{"runs", option.runs},           {"plateau_step", option.plateau_step},
          {"plateaus", option.plateaus_c}, {"sweeps", name_of(option.sweeps)},
          {"hours", option.hours},         {"hours_at_least", option.hours_at_least},
          {"measured", option.measured},   {"sensors", std::move(sensors)}};
}

/// What every option is compared with: shape error of the whole campaign.
json reference_json(const ChamberTime& study) {
  json reference = json::object();
  if (study.options.empty()) return reference;
  for (const Sensor sensor : kSensors) {
    const auto& error = study.options.back().sensors[index_of(sensor)];
    if (error) reference[std::string(name_of(sensor))] = error->rmse_shape * printed_per_si(sensor);
  }
  return reference;
}

}  // namespace

json chamber_time_json(const ChamberTime& study) {
  json options = json::array();
  for (const ChamberTimeOption& option : study.options) options.push_back(option_json(option));
  return {{"hours", study.hours},
          {"runs", study.runs},
          {"reference_rmse_shape", reference_json(study)},
          {"options", std::move(options)},
          {"recommended", study.recommended ? json(*study.recommended) : json()},
          {"recommendation", study.recommended ? json(study.reason) : json()},
          {"reason", study.reason}};
}

}  // namespace soak::calib
