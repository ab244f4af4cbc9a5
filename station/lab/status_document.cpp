// SPDX-License-Identifier: Apache-2.0
#include "station/lab/status_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/units.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string_view name_of(hal::ImuState state) {
  switch (state) {
    case hal::ImuState::closed:
      return "closed";
    case hal::ImuState::silent:
      return "silent";
    case hal::ImuState::configuring:
      return "configuring";
    case hal::ImuState::streaming:
      return "streaming";
    case hal::ImuState::failed:
      return "failed";
  }
  return "";
}

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

json three(const std::array<float, 3>& values, double factor) {
  json list = json::array();
  for (const float value : values) list.push_back(factor * static_cast<double>(value));
  return list;
}

json three_or_null(const std::optional<std::array<double, 3>>& values) { return values ? json(*values) : json(); }

json noise_part(const NoiseFigures& noise) {
  return {{"tau_s", noise.tau_s},
          {"gyro_dps", three_or_null(noise.gyro_dps)},
          {"accel_mps2", three_or_null(noise.accel_mps2)}};
}

json campaign_part(const StatusInput& input) {
  const Plan& plan = input.lab.campaign.plan;
  if (plan.steps.empty()) return nullptr;
  const bool ended = input.step >= plan.steps.size();
  const std::size_t index = std::min(input.step, plan.steps.size() - 1);
  const Step& step = plan.steps[index];
  const double in_step_s = std::max(0.0, input.lab.now_s() - input.step_started_s);
  const double remaining_s = ended ? 0.0 : plan.remaining_s(index + 1) + std::max(0.0, step.estimate_s - in_step_s);
  const double total_s = plan.estimate_s();
  return {{"name", input.lab.campaign.name},
          {"procedure", plan.procedure.name},
          {"purpose", name_of(plan.procedure.purpose)},
          {"run_label", plan.runs[static_cast<std::size_t>(step.run)].label},
          {"run", step.run + 1},
          {"runs", plan.runs.size()},
          {"step", index},
          {"steps", plan.steps.size()},
          {"step_kind", name_of(step.kind)},
          {"step_text", ended ? "all steps are done" : describe(plan, index)},
          {"progress", total_s > 0.0 ? std::clamp(1.0 - remaining_s / total_s, 0.0, 1.0) : 1.0},
          {"remaining_s", remaining_s},
          {"started_utc_s", input.started_utc_s}};
}

json chamber_part(const Lab& lab) {
  const auto& reading = lab.chamber.reading();
  json alarms = json::array();
  if (reading) {
    for (const hal::ChamberAlarm& alarm : reading->alarms) alarms.push_back(alarm.name);
  }
  return {{"description", lab.chamber.chamber().description()},
          {"connected", reading.has_value()},
          {"air_c", reading ? json(reading->air_c) : json()},
          {"set_point_c", reading ? json(reading->set_point_c) : json()},
          {"output_percent", reading ? number_or_null(reading->output_percent) : json()},
          {"air_rh_percent", reading ? number_or_null(reading->air_rh_percent) : json()},
          {"running", reading ? json(reading->running) : json()},
          {"alarms", std::move(alarms)},
          {"age_s", number_or_null(lab.chamber.age_s())}};
}

json fixture_part(const Lab& lab) {
  const auto& reading = lab.fixture_reading();
  return {{"description", lab.fixture ? lab.fixture->description() : "by hand"},
          {"connected", reading.has_value()},
          {"position", reading && reading->position ? json(*reading->position) : json()},
          {"moving", reading ? json(reading->moving) : json()}};
}

/// What the output that feeds the unit said last.
hal::OutputReading supply_of(const Lab& lab, const UnitChannel& unit) {
  const auto& output = unit.slot().power_output;
  const auto reading = lab.supply && output ? lab.supply->reading(*output) : std::nullopt;
  return reading.value_or(hal::OutputReading{});
}

json unit_part(const Lab& lab, const UnitChannel& unit) {
  const hal::OutputReading supply = supply_of(lab, unit);
  const calib::StabilityVerdict verdict = unit.stability();
  const bool streaming = unit.streaming();
  const auto& latest = unit.latest();
  return {{"slot", unit.slot().name},
          {"serial", unit.serial()},
          {"type", unit.type().name},
          {"state", name_of(unit.imu().state())},
          {"powered", streaming ? json(true) : json()},
          {"supply_v", number_or_null(supply.voltage_v)},
          {"supply_a", number_or_null(supply.current_a)},
          {"simulated", unit.simulated()},
          {"temp_c", streaming ? number_or_null(unit.temp_c()) : json()},
          {"slope_kpmin", streaming ? number_or_null(verdict.slope_kpmin) : json()},
          {"slope_half_width_kpmin", streaming ? number_or_null(verdict.half_width_kpmin) : json()},
          {"stable", streaming && verdict.stable},
          {"position", streaming ? text_or_null(unit.position().label) : json()},
          {"samples", unit.imu().statistics().packets},
          {"lost", unit.imu().statistics().lost_packets},
          {"gyro_dps", streaming && latest ? three(latest->rate_rps, base::kDegPerRad) : json()},
          {"accel_mps2", streaming && latest ? three(latest->accel_mps2, 1.0) : json()},
          {"noise", noise_part(unit.noise->figures())}};
}

std::string shown_state(const StatusInput& input) {
  if (input.state != "running") return std::string(input.state);
  if (input.holding || input.lab.prompts.open()) return "waiting";
  const Plan& plan = input.lab.campaign.plan;
  const bool preflight =
      input.step < plan.steps.size() && plan.runs[static_cast<std::size_t>(plan.steps[input.step].run)].preflight;
  return preflight ? "preflight" : "running";
}

}  // namespace

json status_document(const StatusInput& input) {
  const Lab& lab = input.lab;
  json units = json::array();
  for (const auto& unit : lab.units) units.push_back(unit_part(lab, *unit));
  const auto& prompt = lab.prompts.open();
  return {
      {"state", shown_state(input)},
      {"reason", text_or_null(input.holding ? "the chamber does not answer: " + lab.chamber.trouble() : input.reason)},
      {"campaign", campaign_part(input)},
      {"prompt", prompt ? json{{"id", prompt->id}, {"text", prompt->text}} : json()},
      {"chamber", chamber_part(lab)},
      {"fixture", fixture_part(lab)},
      {"units", std::move(units)},
      {"clock", {{"rate", lab.config.clock_rate}, {"process_s", lab.now_s()}}},
      {"simulated", lab.simulated()},
      {"version", SOAK_VERSION}};
}

}  // namespace soak::station
