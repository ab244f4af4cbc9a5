// SPDX-License-Identifier: Apache-2.0
// What the engine watches beside the steps: the chamber, and the conditions under which a campaign is carried on.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <system_error>

#include "station/lab/engine.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kSetPointRepeats = 5;
constexpr double kAtSetPoint_k = 0.5;  ///< between the set point of a step and the one that was commanded
constexpr double kAirMoved_k = 3.0;    ///< from the set point, as for a door that was opened (temperature_steps.cpp)
constexpr double kAirArrived_k = 1.0;  ///< as for a step that drives there
constexpr std::chrono::seconds kDiskInterval{1};
constexpr std::chrono::seconds kProbeInterval{5};  ///< between tries to write where a write has failed

}  // namespace

// --- the chamber ------------------------------------------------------------------------------------------------

void Engine::watch_alarms() {
  const auto alarms = station_->chamber.alarms();
  if (alarms.empty()) return;
  std::string names;
  bool outputs_off = false;
  for (const hal::ChamberAlarm& alarm : alarms) {
    names += names.empty() ? alarm.name : ", " + alarm.name;
    outputs_off = outputs_off || alarm.outputs_off;
  }
  const std::string trouble = "the chamber reports an alarm: " + names;
  // At once: the rest of the way to the safe state can wait.
  outputs_off ? switch_off_chamber(trouble) : end_campaign(CampaignState::failed, trouble);
}

void Engine::watch_guard() {
  const auto& reading = station_->chamber.reading();
  std::vector<GuardedUnit> units;
  for (const auto& unit : station_->units) {
    if (!unit->streaming() || !unit->temp_c()) continue;
    units.push_back({unit->serial(), *unit->temp_c(), unit->type().temp_min_c, unit->type().temp_max_c});
  }
  const auto trouble = guard_.look(station_->now_s(), steady_clock::now(), reading ? &*reading : nullptr, units);
  if (trouble) switch_off_chamber(*trouble);
}

void Engine::switch_off_chamber(const std::string& why) {
  if (safe_end_) return safe_end_->switch_off_at_once(*station_, why);
  if (!chamber_->stop()) log_.add("alarm", "chamber", "heating and cooling cannot be switched off yet");
  end_campaign(CampaignState::failed, why, true);
}

void Engine::heed_watch() {
  if (!watch_) return;
  const bool driven = is_under_way(state_) || state_ == CampaignState::stopping;
  if (!driven) {
    // In the last turn of a campaign, or of the way to the safe state.
    if (const std::string tripped = watch_->verdict().tripped; !tripped.empty()) {
      log_.add("alarm", "chamber", "its watch has switched heating and cooling off: " + tripped);
      resumes_by_itself_ = false;
      hold_queue();
    }
    watch_is_blind_ = false;
    return watch_->disarm();
  }
  watch_->arm(watch_limits(station_->procedure(), config_.dew_point_c));
  watch_->note_engine();
  const WatchVerdict verdict = watch_->verdict();
  // A chamber that does not answer the engine either is reported elsewhere.
  const bool blind = verdict.blind && !station_->chamber.stale();
  if (blind && !watch_is_blind_) {
    log_.add("device", "chamber", "its watch cannot read it over a connection of its own: " + verdict.trouble);
  }
  watch_is_blind_ = blind;
  if (!verdict.tripped.empty()) switch_off_chamber(verdict.tripped);
}

void Engine::watch_set_point() {
  if (!station_->chamber.lost_set_point()) return;
  if (state_ == CampaignState::suspended) void_visit("the chamber lost its set point");
  // One that comes back after a long silence, perhaps off, perhaps with its door open, has the settling time first;
  // while people have it in hand, until they resume.
  if (chamber_is_left_alone_ || suspenders_.has(SuspensionCause::chamber)) return;
  const double expected_c = *station_->chamber.expected_c();
  const auto& reading = *station_->chamber.reading();
  const std::string what = fmt::format("set point is {:+.1f} °C (heating and cooling {}) instead of {:+.1f} °C",
                                       reading.set_point_c, reading.running ? "on" : "off", expected_c);
  set_point_repeats_ = expected_c == repeated_c_ ? set_point_repeats_ + 1 : 1;
  repeated_c_ = expected_c;
  if (set_point_repeats_ > kSetPointRepeats) {
    end_campaign(CampaignState::failed,
                 fmt::format("the chamber's {}, although it was set again {} times", what, kSetPointRepeats));
    return;
  }
  const base::Status sent = chamber_->set_temperature(expected_c).and_then([&] { return chamber_->start(); });
  log_.add("device", "chamber", what + (sent ? ": set again" : ": setting it again failed: " + sent.error().message));
  station_->chamber.expect(expected_c);
  // A campaign that is suspended or paused goes back on its own when it goes on.
  if (state_ == CampaignState::running) repeat_step("the chamber lost its set point");
}

void Engine::hold_for_chamber() {
  const bool silent = station_->chamber.stale();
  if (silent == chamber_is_silent_) return;
  chamber_is_silent_ = silent;
  silent_since_ = steady_clock::now();
  log_.add("device", "chamber",
           silent ? "does not answer, the campaign waits: " + station_->chamber.trouble() : "answers again");
  if (!silent && state_ == CampaignState::running) repeat_step("the chamber did not answer for a while");
  if (state_ == CampaignState::suspended) void_visit("the chamber does not answer, or did not for a while");
}

// --- conditions -------------------------------------------------------------------------------------------------

void Engine::watch_conditions() {
  hold_for_chamber();
  probe_storage();
  follow_air();
  (void)follow_end_of_step();
  const Suspenders::Advice advice = suspenders_.look(station_->now_s(), conditions());
  air_was_away_ = air_was_away_ || suspenders_.has(SuspensionCause::air);
  station_->hold_recording(suspenders_.has(SuspensionCause::disk) || suspenders_.has(SuspensionCause::storage));
  if (state_ == CampaignState::paused) {
    chamber_is_left_alone_ = chamber_is_left_alone_ || suspenders_.has(SuspensionCause::chamber);
    return;
  }
  if (advice == Suspenders::Advice::give_up) {
    return end_campaign(CampaignState::failed, "it has waited for too long or too often: " + suspenders_.text());
  }
  const bool waits = must_wait();
  if (waits && state_ == CampaignState::running) suspend();
  if (state_ != CampaignState::suspended) return;
  // What it waits for brings no unit back in this run.
  if (nothing_is_left_to_record()) {
    return end_campaign(CampaignState::failed, fmt::format("{}; it had waited: {}", kNothingLeft, suspenders_.text()));
  }
  const bool air_moved = air_off_k().value_or(0.0) > kAirMoved_k;
  if (air_moved || suspenders_.spoil_visit()) void_visit(suspenders_.text());
  if (!waits) go_on();
}

bool Engine::nothing_is_left_to_record() const { return station_->run_is_open() && station_->active_units().empty(); }

bool Engine::makes_safe() const {
  const Plan& plan = station_->campaign.plan;
  if (step_ >= plan.steps.size() || ended_) return false;
  return plan.steps[step_].kind == StepKind::warm_end || plan.steps[step_].kind == StepKind::power_off;
}

/// The end of a run needs neither room on the disk nor the units' supply: a chamber that is on its way to the safe
/// state gets there.
bool Engine::must_wait() const {
  if (makes_safe()) return suspenders_.has(SuspensionCause::chamber) || suspenders_.has(SuspensionCause::catalog);
  return !suspenders_.causes().empty();
}

StationConditions Engine::conditions() const {
  StationConditions conditions;
  if (chamber_is_silent_) {
    conditions.chamber_silent_s = std::chrono::duration<double>(steady_clock::now() - silent_since_).count();
  }
  conditions.chamber_trouble = station_->chamber.trouble();
  if (!ends_without_plateau()) conditions.air_off_k = air_off_k();
  conditions.disk_free_bytes = disk_free_bytes_;
  conditions.storage_error = folder_trouble_.empty() ? storage_error_ : folder_trouble_;
  conditions.catalog_error = step_error_;
  conditions.supplies = supplies();
  return conditions;
}

/// Whether the present step has a time-out after which the procedure goes on without the plateau.
bool Engine::ends_without_plateau() const {
  const Plan& plan = station_->campaign.plan;
  return step_ < plan.steps.size() && plan.steps[step_].kind == StepKind::wait_stable &&
         plan.procedure.stability.on_timeout != TimeoutOutcome::abort;
}

/// Until the run is open the units are being switched on, which has its own judgement.
std::vector<StationConditions::Supply> Engine::supplies() const {
  std::vector<StationConditions::Supply> supplies;
  if (!station_->supply || !station_->run_is_open()) return supplies;
  for (const UnitChannel* unit : station_->active_units()) {
    const auto& output = unit->slot().power_output;
    const auto& set_v = unit->slot().supply.voltage_v;
    if (!output || !set_v || !station_->supply->measures(*output)) continue;
    const auto reading = station_->supply->reading(*output);
    // Off or at its current limit the unit is at fault, not the supply: it is dropped, and the others go on.
    if (reading && (!reading->on || is_at_limit(*reading))) continue;
    supplies.push_back({unit->serial(), *set_v, reading ? reading->voltage_v : std::nullopt});
  }
  return supplies;
}

/// Distance of the air from the present visit's set point, where the chamber has been given that.
std::optional<double> Engine::air_off_k() const {
  const auto& reading = station_->chamber.reading();
  const auto& expected_c = station_->chamber.expected_c();
  const Plan& plan = station_->campaign.plan;
  if (!air_has_arrived_ || !reading || !expected_c || step_ >= plan.steps.size()) return std::nullopt;
  const Step& step = plan.steps[step_];
  const bool at_plateau =
      step.visit >= 0 && !air_may_leave(step) && std::abs(*expected_c - step.temp_c) < kAtSetPoint_k;
  return at_plateau ? std::optional(std::abs(reading->air_c - step.temp_c)) : std::nullopt;
}

void Engine::follow_air() {
  const auto& reading = station_->chamber.reading();
  const Plan& plan = station_->campaign.plan;
  if (!reading || step_ >= plan.steps.size() || air_may_leave(plan.steps[step_])) return;
  const Step& step = plan.steps[step_];
  if (step.visit >= 0 && std::abs(reading->air_c - step.temp_c) <= kAirArrived_k) air_has_arrived_ = true;
}

void Engine::watch_data_folder() {
  const auto now = steady_clock::now();
  if (now < next_folder_look_) return;
  next_folder_look_ = now + kDiskInterval;
  std::string trouble = data_folder_.trouble();
  if (trouble == folder_trouble_) return;
  folder_trouble_ = std::move(trouble);
  log_.add("storage", catalog_.data_folder().string(),
           folder_trouble_.empty() ? "the data folder is there again" : folder_trouble_);
}

void Engine::probe_storage() {
  const auto now = steady_clock::now();
  if (now >= next_disk_look_) {
    next_disk_look_ = now + kDiskInterval;
    std::error_code error;
    const auto space = std::filesystem::space(catalog_.data_folder() / "runs", error);
    disk_free_bytes_ = error ? std::nullopt : std::optional(static_cast<double>(space.available));
  }
  if (storage_error_.empty() || now < next_probe_) return;
  next_probe_ = now + kProbeInterval;
  const auto flushed = station_->flush();
  storage_error_ = flushed ? "" : flushed.error().message;
}

void Engine::suspend() {
  air_was_away_ = suspenders_.has(SuspensionCause::air);
  set_state(CampaignState::suspended, suspenders_.text());
}

void Engine::void_visit(const std::string& why) {
  if (visit_is_void_) return;
  visit_is_void_ = true;
  station_->break_segment(why);
  // What begins again asks again: an answer that comes meanwhile would be lost.
  was_asking_ = was_asking_ || station_->prompts.open();
  station_->prompts.withdraw();
  // Nor does what the units send meanwhile belong to a run that is yet to be opened.
  if (!station_->run_is_open()) station_->expect_no_run();
  // Somebody may open the door.
  if (auto halted = station_->halt_fixture(); !halted) {
    log_.add("device", "fixture", "cannot be halted: " + halted.error().message);
  }
}

void Engine::go_on() {
  set_state(CampaignState::running, "goes on; it had waited: " + reason_);
  if (visit_is_void_) repeat_visit();
}

}  // namespace soak::station
