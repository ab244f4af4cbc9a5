// SPDX-License-Identifier: Apache-2.0
// What others see of the engine: docs/http-api.md.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "base/units.h"
#include "station/alarms/alarm_rules.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kPublishInterval{100};

constexpr double kJournalLate_s = 1.0;

std::string_view imu_state_name(hal::ImuState state) {
  constexpr std::array<std::string_view, 5> kNames = {"closed", "silent", "configuring", "streaming", "failed"};
  return kNames.at(static_cast<std::size_t>(state));
}

json null_if_empty(const std::string& text) { return text.empty() ? json() : json(text); }

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

json chamber_part(const Station& station) {
  const auto& reading = station.chamber.reading();
  json alarms = json::array();
  if (reading) {
    for (const hal::ChamberAlarm& alarm : reading->alarms) alarms.push_back(alarm.name);
  }
  return {{"description", station.chamber.chamber().description()},
          {"connected", reading.has_value()},
          {"air_c", reading ? json(reading->air_c) : json()},
          {"set_point_c", reading ? json(reading->set_point_c) : json()},
          {"output_percent", reading ? number_or_null(reading->output_percent) : json()},
          {"air_rh_percent", reading ? number_or_null(reading->air_rh_percent) : json()},
          {"running", reading ? json(reading->running) : json()},
          {"alarms", std::move(alarms)},
          {"age_s", number_or_null(station.chamber.age_s())}};
}

json fixture_part(const Station& station) {
  const auto& reading = station.fixture_reading();
  return {{"description", station.fixture ? station.fixture->description() : "by hand"},
          {"connected", reading.has_value()},
          {"position", reading && reading->position ? json(*reading->position) : json()},
          {"moving", reading ? json(reading->moving) : json()}};
}

/// What the output that feeds the unit said last.
hal::OutputReading supply_of(const Station& station, const UnitChannel& unit) {
  const auto& output = unit.slot().power_output;
  const auto reading = station.supply && output ? station.supply->reading(*output) : std::nullopt;
  return reading.value_or(hal::OutputReading{});
}

/// Which face is up, by the unit's own accelerometers, and which should be; null where no position is expected yet.
/// `right` is null while the unit turns, and for two seconds after.
json attitude_part(const UnitChannel& unit) {
  if (!unit.streaming() || !unit.latest() || unit.position().label.empty()) return nullptr;
  const Attitude attitude = unit.attitude().state();
  const bool known = attitude == Attitude::right || attitude == Attitude::wrong;
  return {{"up", unit.attitude().up_axis()},
          {"expected", unit.position().label},
          {"right", known ? json(attitude == Attitude::right) : json()}};
}

json journal_part(const Journal::Standing& journal) {
  return {{"queued", journal.queued}, {"discarded", journal.discarded}, {"trouble", null_if_empty(journal.trouble)}};
}

json unit_part(const Station& station, const UnitChannel& unit) {
  const hal::OutputReading supply = supply_of(station, unit);
  const calib::StabilityVerdict verdict = unit.stability();
  const bool streaming = unit.streaming();
  const auto& latest = unit.latest();
  return {{"slot", unit.slot().name},
          {"serial", unit.serial()},
          {"type", unit.type().name},
          {"state", imu_state_name(unit.imu().state())},
          {"dropped", null_if_empty(unit.dropped())},
          {"powered", streaming ? json(true) : json()},
          {"supply_v", number_or_null(supply.voltage_v)},
          {"supply_a", number_or_null(supply.current_a)},
          {"simulated", unit.simulated()},
          {"temp_c", streaming ? number_or_null(unit.temp_c()) : json()},
          {"slope_kpmin", streaming ? number_or_null(verdict.slope_kpmin) : json()},
          {"slope_half_width_kpmin", streaming ? number_or_null(verdict.half_width_kpmin) : json()},
          {"stable", streaming && verdict.stable},
          {"position", streaming ? null_if_empty(unit.position().label) : json()},
          {"attitude", attitude_part(unit)},
          {"samples", unit.imu().statistics().packets},
          {"lost", unit.imu().statistics().lost_packets},
          {"gyro_dps", streaming && latest ? three(latest->rate_rps, base::kDegPerRad) : json()},
          {"accel_mps2", streaming && latest ? three(latest->accel_mps2, 1.0) : json()},
          {"noise", noise_part(unit.noise->figures())}};
}

json prompt_part(const std::optional<Prompts::Prompt>& prompt) {
  if (!prompt) return {};
  json about = json::object();
  for (const auto& [name, detail] : prompt->about) {
    std::visit([&](const auto& value) { about[name] = value; }, detail);
  }
  return {{"id", prompt->id}, {"text", prompt->text}, {"code", prompt->code}, {"about", std::move(about)}};
}

}  // namespace

void Engine::publish() {
  const auto now = std::chrono::steady_clock::now();
  if (now - published_ < kPublishInterval) return;
  published_ = now;
  json document = status_document();
  const std::lock_guard lock(status_mutex_);
  if (document == status_) return;
  status_ = std::move(document);
  ++status_version_;
}

json Engine::status_document() const {
  json units = json::array();
  for (const auto& unit : station_->units) units.push_back(unit_part(*station_, *unit));
  json document = {{"state", shown_state()},
                   {"reason", null_if_empty(shown_reason())},
                   {"campaign", campaign_document()},
                   {"suspension", suspension_document()},
                   {"ending", ending_document()},
                   {"journal", journal_part(journal_->standing())},
                   {"data", {{"folder", catalog_.data_folder().string()}, {"trouble", null_if_empty(folder_trouble_)}}},
                   {"prompt", prompt_part(station_->prompts.open())},
                   {"chamber", chamber_part(*station_)},
                   {"fixture", fixture_part(*station_)},
                   {"units", std::move(units)},
                   {"resumable", null_if_empty(unfinished_)},
                   {"resumes_by_itself", resumes_by_itself_ && !stop_requested_},
                   {"queue", queue_document()},
                   {"room",
                    {{"temp_c", config_.room_c},
                     {"dew_point_c", config_.dew_point_c},
                     {"dew_point_assumed", config_.dew_point_assumed}}},
                   {"clock", {{"rate", config_.clock_rate}, {"process_s", station_->now_s()}, {"utc_s", now_utc_s()}}},
                   {"simulated", station_->simulated()},
                   {"version", software_version()}};
  document["alarms"] = alarms_of(document);
  return document;
}

json Engine::suspension_document() const {
  const auto since_s = suspenders_.suspended_since_s();
  if (!since_s || state_ != CampaignState::suspended) return nullptr;
  json causes = json::array();
  for (const SuspensionCause cause : suspenders_.causes()) causes.push_back(name_of(cause));
  const double now_s = station_->now_s();
  return {{"causes", std::move(causes)}, {"for_s", now_s - *since_s}, {"gives_up_in_s", suspenders_.left_s(now_s)}};
}

json Engine::ending_document() const {
  if (state_ != CampaignState::stopping || !safe_end_) return nullptr;
  return {{"outcome", name_of(outcome_)}, {"needs_somebody", safe_end_->needs_somebody(*station_)}};
}

json Engine::campaign_document() const {
  const Plan& plan = station_->campaign.plan;
  if (plan.steps.empty()) return nullptr;
  const bool ended = step_ >= plan.steps.size();
  const std::size_t index = std::min(step_, plan.steps.size() - 1);
  const Step& step = plan.steps[index];
  const double left_s = remaining_s();
  const double total_s = plan.estimate_s();
  return {{"name", station_->campaign.name},
          {"procedure", plan.procedure.name},
          {"purpose", name_of(plan.procedure.purpose)},
          {"run_label", plan.runs[static_cast<std::size_t>(step.run)].label},
          {"run", step.run + 1},
          {"runs", plan.runs.size()},
          {"step", index},
          {"steps", plan.steps.size()},
          {"step_kind", name_of(step.kind)},
          {"step_text", ended ? "all steps are done" : describe(plan, index)},
          {"step_trouble", null_if_empty(step_trouble())},
          {"on_way_back", is_on_way_back()},
          {"progress", total_s > 0.0 ? std::clamp(1.0 - left_s / total_s, 0.0, 1.0) : 1.0},
          {"remaining_s", left_s},
          {"started_utc_s", campaign_started_utc_s_}};
}

std::string_view Engine::shown_state() const {
  if (state_ != CampaignState::running) return name_of(state_);
  if (chamber_is_silent_ || waits_for_journal() || station_->prompts.open()) return "waiting";
  if (!station_->seal_trouble().empty() || !step_trouble().empty()) return "waiting";
  const Plan& plan = station_->campaign.plan;
  const bool preflight =
      step_ < plan.steps.size() && plan.runs[static_cast<std::size_t>(plan.steps[step_].run)].preflight;
  return preflight ? "preflight" : "running";
}

std::string Engine::step_trouble() const { return task_ ? task_->trouble() : ""; }

bool Engine::waits_for_journal() const { return ticket_ && journal_->standing().behind_s > kJournalLate_s; }

std::string Engine::shown_reason() const {
  std::string reason = reason_of_state();
  const auto add = [&](const std::string& text) { reason += (reason.empty() ? "" : "; ") + text; };
  // A campaign that waits for the folder says so anyway.
  if (!folder_trouble_.empty() && state_ != CampaignState::suspended) add(folder_trouble_);
  if (const std::string trouble = notes_.trouble(); !trouble.empty()) {
    add("what soakd is to know of it after a restart cannot be noted, then look after the chamber: " + trouble);
  }
  return reason;
}

std::string Engine::reason_of_state() const {
  if (state_ == CampaignState::suspended) return suspenders_.text();
  if (state_ == CampaignState::running && chamber_is_silent_) {
    return "the chamber does not answer: " + station_->chamber.trouble();
  }
  if (state_ == CampaignState::running && waits_for_journal()) {
    const Journal::Standing journal = journal_->standing();
    return fmt::format("the end of the last step is not written yet, {} entries wait: {}", journal.queued,
                       journal.trouble.empty() ? "the catalog is in use" : journal.trouble);
  }
  if (state_ == CampaignState::running && !station_->seal_trouble().empty()) {
    return "the run cannot be entered into the catalog yet: " + station_->seal_trouble();
  }
  if (state_ == CampaignState::running && !step_trouble().empty()) return step_trouble();
  return safe_end_ ? fmt::format("{}; {}", reason_, safe_end_->text(*station_)) : reason_;
}

json Engine::status() const {
  const std::lock_guard lock(status_mutex_);
  return status_;
}

base::Result<json> Engine::plan(std::optional<std::int64_t> around) const {
  const std::lock_guard lock(status_mutex_);
  if (!around || plan_document_.is_null()) return plan_document_;
  return plan_around(plan_document_, *around);
}

base::Result<json> Engine::noise(const std::string& unit) const {
  std::shared_ptr<const NoiseWatch> watch;
  std::vector<std::string> known;
  {
    const std::lock_guard lock(status_mutex_);
    for (const auto& [serial, of_unit] : noise_) {
      if (serial == unit) watch = of_unit;
      known.push_back(serial);
    }
  }
  if (watch) return watch->document(unit);
  const std::string hint = known.empty() ? "there was no campaign yet"
                                         : fmt::format("the units of the campaign are {}", fmt::join(known, ", "));
  return base::bad_input(fmt::format("there is no unit '{}': {}", unit, hint), "unit");
}

}  // namespace soak::station
