// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "station/config/plan.h"

namespace soak::station {
namespace {

nlohmann::json procedure_document(const Procedure& p) {
  return {{"name", p.name},
          {"description", p.description},
          {"file", p.file},
          {"purpose", name_of(p.purpose)},
          {"kind", name_of(p.kind)},
          {"runs", p.runs},
          {"set_points_c", p.set_points_c},
          {"positions", p.positions},
          {"dwell_s", p.dwell_s},
          {"end_c", p.end_c}};
}

nlohmann::json step_document(const Step& step) {
  nlohmann::json document = {{"kind", name_of(step.kind)},    {"run", step.run},
                             {"temp_c", step.temp_c},         {"sweep", calib::name_of(step.sweep)},
                             {"position", step.position},     {"seconds", step.seconds},
                             {"after_turn", step.after_turn}, {"estimate_s", step.estimate_s}};
  if (step.kind == StepKind::turn_fixture) document["heading_deg"] = step.heading_deg;
  if (step.rate_dps != 0.0) document["rate_dps"] = step.rate_dps;
  document["visit"] = step.visit >= 0 ? nlohmann::json(step.visit) : nlohmann::json();
  return document;
}

}  // namespace

nlohmann::json plan_document(const Plan& plan) {
  nlohmann::json runs = nlohmann::json::array();
  for (const PlannedRun& run : plan.runs) {
    runs.push_back({{"label", run.label},
                    {"preflight", run.preflight},
                    {"first_step", run.first_step},
                    {"last_step", run.last_step}});
  }
  nlohmann::json steps = nlohmann::json::array();
  for (const Step& step : plan.steps) steps.push_back(step_document(step));
  return {{"procedure", procedure_document(plan.procedure)},
          {"runs", std::move(runs)},
          {"steps", std::move(steps)},
          {"estimate_s", plan.estimate_s()}};
}

}  // namespace soak::station
