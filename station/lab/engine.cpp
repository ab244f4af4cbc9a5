// SPDX-License-Identifier: Apache-2.0
// The loop of the engine, and its way from step to step.
#include "station/lab/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "station/io/host.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;
constexpr std::chrono::seconds kChamberTimeout{60};
constexpr std::chrono::seconds kStoreInterval{1};
constexpr int kSetPointRepeats = 5;

/// Steps for which temperature and position were judged. A break makes these judgements void.
bool needs_judgement(StepKind kind) {
  return kind == StepKind::move || kind == StepKind::spin || kind == StepKind::set_temperature ||
         kind == StepKind::wait_stable || kind == StepKind::record;
}

}  // namespace

std::unique_ptr<StepTask> make_task(const Plan& plan, const Step& step) {
  switch (step.kind) {
    case StepKind::power_on:
    case StepKind::power_off:
      return make_power_task(plan, step);
    case StepKind::turn_fixture:
    case StepKind::move:
    case StepKind::spin:
      return make_position_task(step);
    case StepKind::set_temperature:
    case StepKind::wait_stable:
    case StepKind::warm_end:
      return make_temperature_task(plan, step);
    case StepKind::record:
    case StepKind::check:
      return make_record_task(plan, step);
  }
  return nullptr;
}

// --- beginning --------------------------------------------------------------------------------------------------

Engine::Engine(const StationConfig& config, db::Catalog& catalog) : config_(config), catalog_(catalog), log_(catalog) {}

Engine::~Engine() {
  for (const int fd : wake_) {
    if (fd >= 0) ::close(fd);
  }
}

base::Result<std::unique_ptr<Engine>> Engine::make(const StationConfig& config, db::Catalog& catalog) {
  std::unique_ptr<Engine> engine(new Engine(config, catalog));
  if (::pipe2(engine->wake_.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
    return base::fail(base::ErrorKind::internal, "cannot make a pipe");
  }
  if (auto status = engine->make_devices(); !status) return base::forward_error(status);
  if (auto status = engine->take_over(); !status) return base::forward_error(status);
  engine->publish();
  return engine;
}

base::Status Engine::make_devices() {
  auto chamber = hal::make_chamber(config_.chamber);
  if (!chamber) return base::forward_error(chamber);
  chamber_ = *std::move(chamber);
  watch_ = ChamberWatch::make(config_.chamber, config_.clock_rate);
  if (config_.fixture) {
    auto fixture = hal::make_fixture(*config_.fixture);
    if (!fixture) return base::forward_error(fixture);
    fixture_ = *std::move(fixture);
  }
  const auto power = make_power();
  if (!power) return base::forward_error(power);
  station_ = std::make_unique<Station>(config_, catalog_, log_, *chamber_, fixture_.get(), *power);
  return {};
}

base::Result<hal::UnitPower*> Engine::make_power() {
  if (const auto* map = std::get_if<hal::DeviceMap>(&config_.power)) {
    auto made = hal::make_unit_power(*map);
    if (!made) return base::forward_error(made);
    power_ = *std::move(made);
  }
  if (const auto* hubs = std::get_if<hal::UsbHubs>(&config_.power)) power_ = hal::make_usb_hub_power(*hubs);
  const bool from_chamber = std::holds_alternative<PowerFromChamber>(config_.power);
  hal::UnitPower* power = from_chamber ? chamber_->unit_power() : power_.get();
  if (from_chamber && power == nullptr) {
    return base::bad_input("'power.from' is \"chamber\", but the chamber's map has no 'unit_power_1'", config_.file);
  }
  for (const Slot& slot : config_.slots) {
    if (!power || !slot.power_output) continue;
    const auto able = power->check(*slot.power_output, slot.supply);
    if (!able) return base::bad_input(fmt::format("slot {}: {}", slot.name, able.error().message), config_.file);
  }
  return power;
}

/// What a predecessor left behind: a campaign that it did not end is driven to the safe state first.
base::Status Engine::take_over() {
  const auto open = catalog_.open_campaign();
  if (!open) return base::forward_error(open);
  if (!*open) {
    if (auto entered = enter_lost_runs(catalog_, log_); !entered) return entered;
    return restore_unfinished();
  }
  const std::string reason = "soakd ended during the campaign";
  station_->campaign.name = (*open)->name;
  log_.add("campaign", station_->campaign.name,
           reason + "; the chamber is driven to the safe state, then 'soak campaign resume' can continue it");
  restore_units(**open);
  outcome_ = CampaignState::interrupted;
  safe_end_ = std::make_unique<SafeEnd>(reason, station_->procedure().end_c, false, false);
  // Reading what was recorded may take minutes: the chamber comes first.
  runs_are_lost_ = true;
  set_state(CampaignState::stopping, reason);
  return {};
}

base::Status Engine::restore_unfinished() {
  const auto last = catalog_.last_campaign();
  if (!last) return base::forward_error(last);
  if (!*last || ((*last)->state != "interrupted" && (*last)->state != "failed")) return {};
  state_ = (*last)->state == "failed" ? CampaignState::failed : CampaignState::interrupted;
  reason_ = (*last)->reason;
  unfinished_ = station_->campaign.name = (*last)->name;
  return {};
}

void Engine::restore_units(const db::CampaignRow& row) {
  const auto request = request_of(row);
  auto checked = request ? check_start(*request, config_, catalog_) : base::forward_error(request);
  if (checked) {
    station_->campaign.plan.procedure = checked->plan.procedure;
    make_units(*checked);
  } else {
    log_.add("campaign", row.name, "its units cannot be determined any more: " + checked.error().message);
  }
}

void Engine::make_units(const CheckedStart& checked) {
  station_->units.clear();
  const hal::Imu::Settings settings{checked.plan.procedure.rate_hz, checked.plan.procedure.temp_rate_hz};
  for (const CheckedUnit& unit : checked.units) {
    station_->units.push_back(std::make_unique<UnitChannel>(unit.slot, unit.serial, unit.type,
                                                            hal::make_imu(link_of(unit.slot, unit.type)), settings));
  }
  const std::lock_guard lock(status_mutex_);
  noise_.clear();
  for (const auto& unit : station_->units) noise_[unit->serial()] = unit->noise;
}

// --- the loop ---------------------------------------------------------------------------------------------------

void Engine::run(const std::function<void()>& turned) {
  while (true) {
    wait();
    run_commands();
    cycle();
    publish();
    turned();
    if (!stop_requested_) continue;
    if (state_ == CampaignState::running || state_ == CampaignState::paused) {
      end_campaign(CampaignState::interrupted, "soakd was asked to stop");
    }
    if (state_ != CampaignState::stopping) break;
  }
  for (const auto& unit : station_->units) unit->close();
  stopped_ = true;
  run_commands();
}

void Engine::stop() {
  stop_requested_ = true;
  wake();
}

void Engine::wake() {
  const char byte = 0;
  // A full pipe wakes as well.
  (void)!::write(wake_[1], &byte, 1);
}

void Engine::wait() {
  std::vector<pollfd> fds{{wake_[0], POLLIN, 0}};
  for (const auto& unit : station_->units) {
    if (unit->wait_fd() >= 0) fds.push_back({unit->wait_fd(), POLLIN, 0});
  }
  ::poll(fds.data(), fds.size(), kLongestWait_ms);
  std::array<char, 64> bytes{};
  while (::read(wake_[0], bytes.data(), bytes.size()) > 0) {
  }
}

void Engine::cycle() {
  const base::Status stored = station_->poll();
  heed_watch();
  const bool going_on = state_ == CampaignState::running || state_ == CampaignState::paused;
  if (going_on) {
    record_history();
    watch_alarms();
  }
  if (going_on || state_ == CampaignState::stopping) watch_guard();
  if (!stored && (state_ == CampaignState::running || state_ == CampaignState::paused)) {
    end_campaign(CampaignState::failed, "cannot record: " + stored.error().message);
  }
  if (journal_is_behind_) store_state();
  if (going_on && !hold_for_chamber()) watch_set_point();
  if (state_ == CampaignState::running && !stale_since_) advance();
  if (state_ == CampaignState::stopping && safe_end_->poll(*station_) && runs_of_predecessor_are_entered()) {
    const std::string reason = safe_end_->reason();
    safe_end_.reset();
    set_state(outcome_, reason, std::string(state_user_));
  }
}

void Engine::advance() {
  if (station_->run_is_open() && station_->active_units().empty()) {
    end_campaign(CampaignState::failed, "no unit is left in this run");
    return;
  }
  const StepProgress progress = task_->poll(*station_);
  if (progress.state != StepState::running) step_ended(progress);
}

bool Engine::runs_of_predecessor_are_entered() {
  if (!runs_are_lost_) return true;
  const auto entered = station_->enter_left_runs();
  if (entered && !*entered) return false;
  runs_are_lost_ = false;
  if (!entered) {
    log_.add("run", station_->campaign.name,
             "what was recorded cannot be entered into the catalog: " + entered.error().message);
  }
  return true;
}

void Engine::record_history() {
  const auto& reading = station_->chamber.reading();
  std::vector<std::optional<double>> units_c;
  for (const auto& unit : station_->units) units_c.push_back(unit->streaming() ? unit->temp_c() : std::nullopt);
  history_.add(station_->now_s(), reading ? std::optional(reading->air_c) : std::nullopt,
               reading ? std::optional(reading->set_point_c) : std::nullopt, units_c);
}

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
  // At once: the rest of the way to the safe state can wait.
  if (outputs_off && !chamber_->stop()) log_.add("alarm", "chamber", "heating and cooling cannot be switched off yet");
  end_campaign(CampaignState::failed, "the chamber reports an alarm: " + names, outputs_off);
}

void Engine::watch_guard() {
  const auto& reading = station_->chamber.reading();
  std::vector<GuardedUnit> units;
  for (const auto& unit : station_->units) {
    if (!unit->streaming() || !unit->temp_c()) continue;
    units.push_back({unit->serial(), *unit->temp_c(), unit->type().temp_min_c, unit->type().temp_max_c});
  }
  const auto trouble = guard_.look(station_->now_s(), steady_clock::now(), reading ? &*reading : nullptr, units);
  if (!trouble) return;
  if (safe_end_) return safe_end_->switch_off_at_once(*station_, *trouble);
  if (!chamber_->stop()) log_.add("alarm", "chamber", "heating and cooling cannot be switched off yet");
  end_campaign(CampaignState::failed, *trouble, true);
}

void Engine::heed_watch() {
  if (!watch_) return;
  const bool driven =
      state_ == CampaignState::running || state_ == CampaignState::paused || state_ == CampaignState::stopping;
  if (!driven) {
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
  if (verdict.tripped.empty()) return;
  if (safe_end_) return safe_end_->switch_off_at_once(*station_, verdict.tripped);
  end_campaign(CampaignState::failed, verdict.tripped, true);
}

void Engine::watch_set_point() {
  if (!station_->chamber.lost_set_point()) return;
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
  repeat_step("the chamber lost its set point");
}

bool Engine::hold_for_chamber() {
  if (!station_->chamber.stale()) {
    if (stale_since_) {
      stale_since_.reset();
      log_.add("device", "chamber", "answers again");
      repeat_step("the chamber did not answer for a while");
    }
    return false;
  }
  const auto now = steady_clock::now();
  if (!stale_since_) {
    stale_since_ = now;
    log_.add("device", "chamber", "does not answer, the campaign waits: " + station_->chamber.trouble());
  }
  if (now - *stale_since_ > kChamberTimeout) {
    end_campaign(CampaignState::failed, "the chamber does not answer: " + station_->chamber.trouble());
  }
  return true;
}

// --- from step to step ------------------------------------------------------------------------------------------

void Engine::enter_step(std::size_t index) {
  const Plan& plan = station_->campaign.plan;
  step_ = index;
  step_started_utc_s_ = now_utc_s();
  step_started_s_ = station_->now_s();
  station_->prompts.withdraw();
  Step step = plan.steps[index];
  if (step.kind == StepKind::wait_stable && std::exchange(settle_fully_, false)) step.after_turn = false;
  task_ = make_task(plan, step);
  published_ = {};
}

void Engine::step_ended(const StepProgress& progress) {
  const Plan& plan = station_->campaign.plan;
  if (progress.state == StepState::failed) {
    log_.add("step", describe(plan, step_), "failed: " + progress.text);
    store_step("failed", progress.text);
    end_campaign(CampaignState::failed,
                 progress.error.where.empty() ? progress.text : progress.error.where + ": " + progress.text);
    return;
  }
  if (!progress.text.empty()) log_.add("step", describe(plan, step_), progress.text);
  const bool skip = progress.state == StepState::skip_visit;
  if (const auto flushed = station_->flush(); !flushed) {
    end_campaign(CampaignState::failed, "cannot record: " + flushed.error().message);
    return;
  }
  if (!store_step(skip ? "skipped" : "done", progress.text)) return;
  if (is_on_way_back()) {
    enter_step(way_back_[++way_at_]);
    return;
  }
  std::size_t next = step_ + 1;
  if (skip) {
    const Step& here = plan.steps[step_];
    while (next < plan.steps.size() && plan.steps[next].run == here.run && plan.steps[next].visit == here.visit) ++next;
  }
  if (next < plan.steps.size()) {
    enter_step(next);
  } else {
    task_.reset();
    step_ = plan.steps.size();
    const auto& missing = station_->campaign.missing_units;
    set_state(CampaignState::finished, missing.empty() ? "" : fmt::format("without {}", fmt::join(missing, ", ")));
  }
}

double Engine::estimate_after_step_s() const {
  const Plan& plan = station_->campaign.plan;
  if (!is_on_way_back()) return plan.remaining_s(step_ + 1);
  double seconds = plan.remaining_s(way_back_.back() + 1);
  for (std::size_t i = way_at_ + 1; i < way_back_.size(); ++i) seconds += plan.steps[way_back_[i]].estimate_s;
  return seconds;
}

bool Engine::store_step(const std::string& outcome, const std::string& text) {
  db::StepRow row;
  row.campaign = station_->campaign.name;
  row.index = static_cast<std::int32_t>(step_);
  row.attempt = step_attempts_[step_]++;
  row.started_utc_s = step_started_utc_s_;
  row.ended_utc_s = now_utc_s();
  row.outcome = outcome;
  row.text = text;
  row.run_id = station_->run_id();
  const auto stored = catalog_.complete_step(row);
  if (!stored) end_campaign(CampaignState::failed, "the journal cannot be written: " + stored.error().message);
  return stored.has_value();
}

void Engine::repeat_step(const std::string& why) {
  const Plan& plan = station_->campaign.plan;
  station_->break_segment(why);
  if (!needs_judgement(plan.steps[step_].kind)) return;
  if (is_on_way_back()) {
    while (way_at_ > 0 && needs_judgement(plan.steps[way_back_[way_at_ - 1]].kind)) --way_at_;
    enter_step(way_back_[way_at_]);
    return;
  }
  std::size_t step = step_;
  const auto same_visit = [&](std::size_t other) {
    return plan.steps[other].run == plan.steps[step].run && plan.steps[other].visit == plan.steps[step].visit;
  };
  while (step > 0 && plan.steps[step].kind != StepKind::move && same_visit(step - 1) &&
         needs_judgement(plan.steps[step - 1].kind)) {
    --step;
  }
  settle_fully_ = plan.steps[step_].visit >= 0;
  enter_step(step);
}

// --- states -----------------------------------------------------------------------------------------------------

void Engine::set_state(CampaignState state, const std::string& reason, const std::string& user) {
  state_ = state;
  reason_ = reason;
  state_user_ = user;
  const std::string& campaign = station_->campaign.name;
  log_.add("campaign", campaign,
           reason.empty() ? std::string(name_of(state)) : fmt::format("{}: {}", name_of(state), reason), user);
  // On the way to the safe state the journal's campaign stays open: if soakd ends now, the next one continues that way.
  if (state == CampaignState::stopping) return;
  next_store_ = {};
  journal_is_behind_ = true;
  store_state();
  if (state != CampaignState::running && state != CampaignState::paused) {
    const bool resumable = state == CampaignState::interrupted || state == CampaignState::failed;
    unfinished_ = resumable ? campaign : "";
    for (const auto& unit : station_->units) unit->close();
  }
}

void Engine::store_state() {
  const auto now = steady_clock::now();
  if (now < next_store_) return;
  next_store_ = now + kStoreInterval;
  const auto stored = catalog_.set_campaign_state(station_->campaign.name, name_of(state_), reason_, state_user_);
  journal_is_behind_ = !stored;
  if (!stored) log_line("the journal cannot be written: " + stored.error().message);
}

void Engine::end_campaign(CampaignState outcome, const std::string& reason, bool outputs_off, const std::string& user) {
  if (state_ == CampaignState::stopping) return;
  task_.reset();
  station_->prompts.withdraw();
  station_->break_segment(reason);
  station_->set_plateau(std::nullopt, calib::Sweep::unknown, -1);
  station_->chamber.expect(std::nullopt);
  stale_since_.reset();
  outcome_ = outcome;
  safe_end_ =
      std::make_unique<SafeEnd>(reason, station_->procedure().end_c, outputs_off, outcome == CampaignState::aborted);
  set_state(CampaignState::stopping, reason, user);
}

}  // namespace soak::station
