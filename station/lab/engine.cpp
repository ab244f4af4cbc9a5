// SPDX-License-Identifier: Apache-2.0
#include "station/lab/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "station/io/host.h"
#include "station/lab/lost_runs.h"
#include "station/lab/start_check.h"
#include "station/lab/status_document.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;
constexpr std::chrono::milliseconds kPublishEvery{100};
constexpr std::chrono::seconds kChamberPatience{60};
constexpr std::chrono::seconds kKeepAgain{1};
constexpr int kTellAgain = 5;

}  // namespace

std::string_view name_of(LabState state) {
  switch (state) {
    case LabState::idle:
      return "idle";
    case LabState::running:
      return "running";
    case LabState::paused:
      return "paused";
    case LabState::stopping:
      return "stopping";
    case LabState::interrupted:
      return "interrupted";
    case LabState::finished:
      return "finished";
    case LabState::aborted:
      return "aborted";
    case LabState::failed:
      return "failed";
  }
  return "";
}

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
  if (config_.fixture) {
    auto fixture = hal::make_modbus_fixture(*config_.fixture);
    if (!fixture) return base::forward_error(fixture);
    fixture_ = *std::move(fixture);
  }
  const auto power = make_power();
  if (!power) return base::forward_error(power);
  lab_ = std::make_unique<Lab>(config_, catalog_, log_, *chamber_, fixture_.get(), *power);
  return {};
}

base::Result<hal::UnitPower*> Engine::make_power() {
  if (const auto* map = std::get_if<hal::ChamberMap>(&config_.power)) {
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

void Engine::make_units(const CheckedStart& checked) {
  lab_->units.clear();
  const hal::Imu::Settings settings{checked.plan.procedure.rate_hz, checked.plan.procedure.temp_rate_hz};
  for (const CheckedUnit& unit : checked.units) {
    lab_->units.push_back(std::make_unique<UnitChannel>(unit.slot, unit.serial, unit.type,
                                                        hal::make_imu(link_of(unit.slot, unit.type)), settings));
  }
  const std::lock_guard lock(status_mutex_);
  noise_.clear();
  for (const auto& unit : lab_->units) noise_[unit->serial()] = unit->noise;
}

// --- the loop ---------------------------------------------------------------------------------------------------

void Engine::run() {
  while (true) {
    wait();
    serve_commands();
    turn();
    publish();
    if (!stop_requested_) continue;
    if (state_ == LabState::running || state_ == LabState::paused) {
      end_campaign(LabState::interrupted, "soakd was asked to stop");
    }
    if (state_ != LabState::stopping) break;
  }
  for (const auto& unit : lab_->units) unit->close();
  stopped_ = true;
  serve_commands();
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
  for (const auto& unit : lab_->units) {
    if (unit->wait_fd() >= 0) fds.push_back({unit->wait_fd(), POLLIN, 0});
  }
  ::poll(fds.data(), fds.size(), kLongestWait_ms);
  std::array<char, 64> bytes{};
  while (::read(wake_[0], bytes.data(), bytes.size()) > 0) {
  }
}

void Engine::turn() {
  const base::Status stored = lab_->poll();
  const bool going_on = state_ == LabState::running || state_ == LabState::paused;
  if (going_on) {
    remember();
    watch_alarms();
  }
  if (!stored && (state_ == LabState::running || state_ == LabState::paused)) {
    end_campaign(LabState::failed, "cannot record: " + stored.error().message);
  }
  if (journal_is_behind_) keep_state();
  if (going_on && !hold_for_chamber()) watch_set_point();
  if (state_ == LabState::running && !stale_since_) advance();
  if (state_ == LabState::stopping && safe_end_->poll(*lab_)) {
    const std::string reason = safe_end_->reason();
    safe_end_.reset();
    settle_lost_runs();
    set_state(outcome_, reason);
  }
}

void Engine::settle_lost_runs() {
  if (!runs_are_lost_) return;
  runs_are_lost_ = false;
  if (const auto entered = enter_lost_runs(catalog_, log_); !entered) {
    log_.add("run", lab_->campaign.name, "what was recorded cannot be entered: " + entered.error().message);
  }
}

void Engine::remember() {
  const auto& reading = lab_->chamber.reading();
  std::vector<std::optional<double>> units_c;
  for (const auto& unit : lab_->units) units_c.push_back(unit->streaming() ? unit->temp_c() : std::nullopt);
  history_.add(lab_->now_s(), reading ? std::optional(reading->air_c) : std::nullopt,
               reading ? std::optional(reading->set_point_c) : std::nullopt, units_c);
}

void Engine::watch_alarms() {
  const auto& reading = lab_->chamber.reading();
  if (!reading || reading->alarms.empty()) return;
  std::string names;
  bool outputs_off = false;
  for (const hal::ChamberAlarm& alarm : reading->alarms) {
    names += names.empty() ? alarm.name : ", " + alarm.name;
    outputs_off = outputs_off || alarm.outputs_off;
  }
  // Not a moment later than this: the rest of the way to the safe state can wait.
  if (outputs_off && !chamber_->stop()) log_.add("alarm", "chamber", "heating and cooling cannot be switched off yet");
  end_campaign(LabState::failed, "the chamber reports an alarm: " + names, outputs_off);
}

void Engine::watch_set_point() {
  if (!lab_->chamber.disobeys()) return;
  const double expected_c = *lab_->chamber.expected_c();
  const auto& reading = *lab_->chamber.reading();
  const std::string what = fmt::format("holds {:+.1f} °C, {}, where {:+.1f} °C was asked for", reading.set_point_c,
                                       reading.running ? "on" : "off", expected_c);
  told_again_ = expected_c == told_c_ ? told_again_ + 1 : 1;
  told_c_ = expected_c;
  if (told_again_ > kTellAgain) {
    end_campaign(LabState::failed, "the chamber " + what + ", however often it is told");
    return;
  }
  const base::Status told = chamber_->set_temperature(expected_c).and_then([&] { return chamber_->start(); });
  log_.add("device", "chamber", what + (told ? ": told again" : ": refuses: " + told.error().message));
  lab_->chamber.expect(expected_c);
  repeat_step("the chamber did not hold its set point");
}

bool Engine::hold_for_chamber() {
  if (!lab_->chamber.stale()) {
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
    log_.add("device", "chamber", "does not answer, holding: " + lab_->chamber.trouble());
  }
  if (now - *stale_since_ > kChamberPatience) {
    end_campaign(LabState::failed, "the chamber does not answer: " + lab_->chamber.trouble());
  }
  return true;
}

void Engine::advance() {
  if (lab_->run_is_open() && lab_->active_units().empty()) {
    end_campaign(LabState::failed, "no unit is left in this run");
    return;
  }
  const StepProgress progress = task_->poll(*lab_);
  if (progress.state != StepState::running) step_ended(progress);
}

// --- states -----------------------------------------------------------------------------------------------------

void Engine::set_state(LabState state, const std::string& reason) {
  state_ = state;
  reason_ = reason;
  const std::string& campaign = lab_->campaign.name;
  log_.add("campaign", campaign,
           reason.empty() ? std::string(name_of(state)) : fmt::format("{}: {}", name_of(state), reason));
  // On the way to the safe state the journal's campaign stays open: if soakd dies now, the next one goes on with that.
  if (state == LabState::stopping) return;
  next_keep_ = {};
  journal_is_behind_ = true;
  keep_state();
  if (state != LabState::running && state != LabState::paused) {
    const bool resumable = state == LabState::interrupted || state == LabState::failed;
    unfinished_ = resumable ? campaign : "";
    for (const auto& unit : lab_->units) unit->close();
  }
}

void Engine::keep_state() {
  const auto now = steady_clock::now();
  if (now < next_keep_) return;
  next_keep_ = now + kKeepAgain;
  const auto kept = catalog_.set_campaign_state(lab_->campaign.name, name_of(state_), reason_);
  journal_is_behind_ = !kept;
  if (!kept) log_line("the journal cannot be written: " + kept.error().message);
}

void Engine::end_campaign(LabState outcome, const std::string& reason, bool outputs_off) {
  if (state_ == LabState::stopping) return;
  task_.reset();
  lab_->prompts.withdraw();
  lab_->break_segment(reason);
  lab_->set_plateau(std::nullopt, calib::Sweep::unknown, -1);
  lab_->chamber.expect(std::nullopt);
  stale_since_.reset();
  outcome_ = outcome;
  safe_end_ = std::make_unique<SafeEnd>(reason, lab_->procedure().end_c, outputs_off);
  set_state(LabState::stopping, reason);
}

// --- what others see --------------------------------------------------------------------------------------------

void Engine::publish() {
  const auto now = steady_clock::now();
  if (now - published_ < kPublishEvery) return;
  published_ = now;
  StatusInput input{*lab_,           name_of(state_),         reason_, step_, campaign_started_utc_s_,
                    step_started_s_, stale_since_.has_value()};
  if (safe_end_) input.reason = fmt::format("{}; {}", reason_, safe_end_->text(*lab_));
  nlohmann::json document = status_document(input);
  const std::lock_guard lock(status_mutex_);
  if (document == status_) return;
  status_ = std::move(document);
  ++status_version_;
}

nlohmann::json Engine::status() const {
  const std::lock_guard lock(status_mutex_);
  return status_;
}

nlohmann::json Engine::plan() const {
  const std::lock_guard lock(status_mutex_);
  return plan_document_;
}

base::Result<nlohmann::json> Engine::noise(const std::string& unit) const {
  std::shared_ptr<const NoiseWatch> watch;
  std::vector<std::string> known;
  {
    const std::lock_guard lock(status_mutex_);
    for (const auto& [serial, of] : noise_) {
      if (serial == unit) watch = of;
      known.push_back(serial);
    }
  }
  if (watch) return watch->document(unit);
  const std::string there_are =
      known.empty() ? "there was no campaign yet" : fmt::format("the campaign has {}", fmt::join(known, ", "));
  return base::bad_input(fmt::format("there is no unit '{}': {}", unit, there_are), "unit");
}

}  // namespace soak::station
