// SPDX-License-Identifier: Apache-2.0
// The engine's beginning and its loop.
#include "station/lab/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <thread>
#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;
constexpr std::chrono::seconds kResumeInterval{60};  ///< between tries to resume by itself
/// soakd's end waits so long for a catalog that is locked. What is not written then is lost but for soakd's own log;
/// the campaign is open there, and the next soakd takes it over.
constexpr std::chrono::seconds kLongestGoodbye{30};
constexpr std::chrono::milliseconds kGoodbyeTurn{100};
constexpr std::chrono::seconds kEntryOfResume{2};  ///< for which a try to resume waits for the catalog

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

Engine::Engine(const StationConfig& config, db::Catalog& catalog, std::unique_ptr<Journal> journal)
    : config_(config),
      catalog_(catalog),
      journal_(std::move(journal)),
      log_(*journal_),
      note_file_(catalog.data_folder() / "soakd.campaign"),
      note_(note_file_.read()) {}

Engine::~Engine() {
  journal_->end();  // it wakes the engine
  for (const int fd : wake_) {
    if (fd >= 0) ::close(fd);
  }
}

base::Result<std::unique_ptr<Engine>> Engine::make(const StationConfig& config, db::Catalog& catalog) {
  std::array<int, 2> pipe{-1, -1};
  if (::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
    return base::fail(base::ErrorKind::internal, "cannot make a pipe");
  }
  auto journal = Journal::open(catalog.data_folder(), [fd = pipe[1]] { wake_at(fd); });
  if (!journal) {
    for (const int fd : pipe) ::close(fd);
    return base::forward_error(journal);
  }
  std::unique_ptr<Engine> engine(new Engine(config, catalog, *std::move(journal)));
  engine->wake_ = pipe;
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
  station_->campaign.name = (*open)->name;
  if (note_.campaign != (*open)->name) note_ = {.campaign = (*open)->name};
  outcome_ = note_.outcome == name_of(CampaignState::aborted)  ? CampaignState::aborted
             : note_.outcome == name_of(CampaignState::failed) ? CampaignState::failed
                                                               : CampaignState::interrupted;
  const bool was_cut_short = outcome_ == CampaignState::interrupted;
  const std::string reason = was_cut_short ? "soakd ended during the campaign" : note_.reason;
  resumes_by_itself_ = was_cut_short && note_.goes_on;
  log_.add("campaign", station_->campaign.name,
           fmt::format("soakd ended before the campaign did; the chamber is driven to the safe state, then {}",
                       resumes_by_itself_ ? "it goes on"
                       : was_cut_short    ? "'soak campaign resume' can continue it"
                                          : fmt::format("it is {}", name_of(outcome_))));
  restore_units(**open);
  safe_end_ = std::make_unique<SafeEnd>(reason, station_->procedure().end_c, false, false);
  // Reading what was recorded may take minutes: the chamber comes first.
  runs_are_lost_ = true;
  set_state(CampaignState::stopping, reason, was_cut_short ? "" : std::string(note_.user));
  return {};
}

base::Status Engine::restore_unfinished() {
  const auto last = catalog_.last_campaign();
  if (!last) return base::forward_error(last);
  if (!*last || ((*last)->state != "interrupted" && (*last)->state != "failed")) return {};
  state_ = (*last)->state == "failed" ? CampaignState::failed : CampaignState::interrupted;
  reason_ = (*last)->reason;
  unfinished_ = station_->campaign.name = (*last)->name;
  resumes_by_itself_ = state_ == CampaignState::interrupted && note_.campaign == unfinished_ && note_.goes_on;
  return {};
}

void Engine::resume_by_itself() {
  if (steady_clock::now() < next_resume_) return;
  const auto entered = station_->enter_left_runs();
  if (entered && !*entered) return;  // beside this thread: the next turn asks again
  next_resume_ = steady_clock::now() + kResumeInterval;
  const auto resumed = entered ? try_to_resume() : base::forward_error(entered);
  if (resumed) return;
  const base::Error& error = resumed.error();
  // A device may still be starting, as the computer was, or the catalog be locked. A refusal of the plan is for people.
  resumes_by_itself_ = error.kind != base::ErrorKind::bad_input;
  log_.add(
      "campaign", unfinished_,
      fmt::format("{}: {}: {}", resumes_by_itself_ ? "cannot be resumed yet" : "is not resumed, it waits for somebody",
                  error.where, error.message));
}

base::Status Engine::try_to_resume() {
  if (journal_->wait_until_written(kEntryOfResume)) return do_resume("soakd");
  return base::fail(base::ErrorKind::internal, journal_->standing().trouble, "journal");
}

// --- what the next soakd is to know ------------------------------------------------------------------------------

CampaignNote Engine::note_now() const {
  CampaignNote note{.campaign = station_->campaign.name};
  switch (state_) {
    case CampaignState::running:
    case CampaignState::suspended:
      // Somebody who is asked for something may have the door open.
      note.goes_on =
          has_come_on_ && station_->procedure().on_restart == RestartOutcome::resume && !station_->prompts.open();
      return note;
    case CampaignState::stopping:
      if (outcome_ != CampaignState::interrupted) {
        note.outcome = name_of(outcome_);
        note.reason = reason_;
        note.user = state_user_;
        return note;
      }
      [[fallthrough]];
    case CampaignState::interrupted:
      // As it stood before soakd was to end, unless somebody has decided otherwise since.
      note.goes_on = note_.goes_on && note_.campaign == note.campaign && (resumes_by_itself_ || stop_requested_);
      return note;
    case CampaignState::idle:
      return note_;
    case CampaignState::paused:
    case CampaignState::finished:
    case CampaignState::aborted:
    case CampaignState::failed:
      break;
  }
  return note;
}

void Engine::keep_note() {
  const CampaignNote note = note_now();
  if (note == note_) return;
  note_ = note;
  note_file_.keep(note);
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
    end_campaign(CampaignState::interrupted, "soakd was asked to stop");
    if (state_ != CampaignState::stopping) break;
  }
  const auto longest = steady_clock::now() + kLongestGoodbye;
  while (!journal_->wait_until_written(kGoodbyeTurn) && steady_clock::now() < longest) {
    run_commands();
    turned();
  }
  for (const auto& unit : station_->units) unit->close();
  stopped_ = true;
  run_commands();
}

void Engine::stop() {
  stop_requested_ = true;
  wake();
}

void Engine::wake() { wake_at(wake_[1]); }

void Engine::wake_at(int fd) {
  const char byte = 0;
  // A full pipe wakes as well.
  (void)!::write(fd, &byte, 1);
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
  if (const base::Status stored = station_->poll(); !stored) {
    storage_error_ = stored.error().message;
    // Nobody looks for room any more: what cannot be written must not pile up.
    if (state_ == CampaignState::stopping) station_->hold_recording(true);
  }
  heed_watch();
  if (is_under_way(state_)) {
    record_history();
    watch_alarms();
  }
  if (is_under_way(state_) || state_ == CampaignState::stopping) watch_guard();
  if (is_under_way(state_)) watch_conditions();
  if (is_under_way(state_) && !chamber_is_silent_) watch_set_point();
  if (state_ == CampaignState::running && !chamber_is_silent_) advance();
  if (state_ == CampaignState::interrupted && resumes_by_itself_ && !stop_requested_) resume_by_itself();
  if (state_ == CampaignState::stopping && safe_end_->poll(*station_) && runs_of_predecessor_are_entered()) {
    safe_end_.reset();
    set_state(outcome_, std::string(reason_), std::string(state_user_));
  }
  keep_note();
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

}  // namespace soak::station
