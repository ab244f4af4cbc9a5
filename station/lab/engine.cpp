// SPDX-License-Identifier: Apache-2.0
#include "station/lab/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "station/identity.h"
#include "station/lab/lost_runs.h"
#include "station/lab/start_check.h"
#include "station/lab/status_document.h"
#include "station/log.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;
constexpr std::chrono::milliseconds kPublishEvery{100};
constexpr std::chrono::seconds kChamberPatience{60};
constexpr std::chrono::seconds kKeepAgain{1};
constexpr int kTellAgain = 5;
constexpr double kEnd_c = 25.0;

base::Error wrong_state(std::string message) { return {base::ErrorKind::bad_input, std::move(message), "state"}; }

/// Steps that stand on a judgement of temperature and position, which a break makes void.
bool stands_on_judgement(StepKind kind) {
  return kind == StepKind::move || kind == StepKind::set_temperature || kind == StepKind::wait_stable ||
         kind == StepKind::record;
}

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
  auto chamber = hal::make_modbus_chamber(config_.chamber);
  if (!chamber) return base::forward_error(chamber);
  chamber_ = *std::move(chamber);
  if (config_.fixture) {
    auto fixture = hal::make_modbus_fixture(*config_.fixture);
    if (!fixture) return base::forward_error(fixture);
    fixture_ = *std::move(fixture);
  }
  if (config_.power) {
    auto power = hal::make_modbus_power(*config_.power);
    if (!power) return base::forward_error(power);
    power_ = *std::move(power);
  }
  lab_ = std::make_unique<Lab>(config_, catalog_, log_, *chamber_, fixture_.get(), power_.get());
  return {};
}

base::Status Engine::take_over() {
  const auto open = catalog_.open_campaign();
  if (!open) return base::forward_error(open);
  if (!*open) {
    if (auto entered = enter_lost_runs(catalog_, log_); !entered) return entered;
    return know_unfinished();
  }
  const std::string reason = "soakd ended in mid-campaign";
  lab_->campaign.name = (*open)->name;
  log_.add("campaign", lab_->campaign.name,
           reason + "; the chamber is driven to the safe state, then 'soak campaign resume' goes on");
  know_units_of(**open);
  outcome_ = LabState::interrupted;
  safe_end_ = std::make_unique<SafeEnd>(reason, kEnd_c, false);
  // Reading what was recorded may take minutes: the chamber comes first.
  runs_are_lost_ = true;
  set_state(LabState::stopping, reason);
  return {};
}

base::Status Engine::know_unfinished() {
  const auto last = catalog_.last_campaign();
  if (!last) return base::forward_error(last);
  if (!*last || ((*last)->state != "interrupted" && (*last)->state != "failed")) return {};
  state_ = (*last)->state == "failed" ? LabState::failed : LabState::interrupted;
  reason_ = (*last)->reason;
  unfinished_ = lab_->campaign.name = (*last)->name;
  return {};
}

void Engine::know_units_of(const db::CampaignRow& row) {
  const auto request = request_of(row);
  auto checked = request ? check_start(*request, config_, catalog_) : base::forward_error(request);
  if (checked) {
    make_units(*checked);
  } else {
    log_.add("campaign", row.name, "its units are not known any more: " + checked.error().message);
  }
}

void Engine::make_units(const CheckedStart& checked) {
  lab_->units.clear();
  const hal::Imu::Settings settings{checked.plan.procedure.rate_hz, checked.plan.procedure.temp_rate_hz};
  for (const CheckedUnit& unit : checked.units) {
    lab_->units.push_back(std::make_unique<UnitChannel>(unit.slot, unit.serial, unit.type,
                                                        hal::make_xsens_imu(unit.slot.address), settings));
  }
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

// --- steps ------------------------------------------------------------------------------------------------------

void Engine::enter_step(std::size_t step) {
  step_ = step;
  step_started_utc_s_ = now_utc_s();
  step_started_s_ = lab_->now_s();
  lab_->prompts.withdraw();
  task_ = new_task(step);
  published_ = {};
}

std::unique_ptr<StepTask> Engine::new_task(std::size_t index) {
  const Plan& plan = lab_->campaign.plan;
  if (!settle_fully_ || plan.steps[index].kind != StepKind::wait_stable) return make_task(plan, index);
  settle_fully_ = false;
  Step step = plan.steps[index];
  step.after_turn = false;
  return make_wait_stable(plan, step);
}

void Engine::step_ended(const StepProgress& progress) {
  const Plan& plan = lab_->campaign.plan;
  if (progress.state == StepState::failed) {
    log_.add("step", describe(plan, step_), "failed: " + progress.text);
    persist_step("failed", progress.text);
    end_campaign(LabState::failed,
                 progress.error.where.empty() ? progress.text : progress.error.where + ": " + progress.text);
    return;
  }
  if (!progress.text.empty()) log_.add("step", describe(plan, step_), progress.text);
  const bool skip = progress.state == StepState::skip_visit;
  if (!persist_step(skip ? "skipped" : "done", progress.text)) return;
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
    const auto& losses = lab_->campaign.losses;
    set_state(LabState::finished, losses.empty() ? "" : fmt::format("without {}", fmt::join(losses, ", ")));
  }
}

bool Engine::persist_step(const std::string& outcome, const std::string& text) {
  db::StepRow row;
  row.campaign = lab_->campaign.name;
  row.index = static_cast<std::int32_t>(step_);
  row.attempt = step_attempts_[step_]++;
  row.started_utc_s = step_started_utc_s_;
  row.ended_utc_s = now_utc_s();
  row.outcome = outcome;
  row.text = text;
  row.run_id = lab_->run_id();
  const auto kept = catalog_.complete_step(row);
  if (!kept) end_campaign(LabState::failed, "the journal cannot be written: " + kept.error().message);
  return kept.has_value();
}

void Engine::repeat_step(const std::string& why) {
  const Plan& plan = lab_->campaign.plan;
  lab_->break_segment(why);
  if (!stands_on_judgement(plan.steps[step_].kind)) return;
  std::size_t step = step_;
  const auto same_visit = [&](std::size_t other) {
    return plan.steps[other].run == plan.steps[step].run && plan.steps[other].visit == plan.steps[step].visit;
  };
  while (step > 0 && plan.steps[step].kind != StepKind::move && same_visit(step - 1) &&
         stands_on_judgement(plan.steps[step - 1].kind)) {
    --step;
  }
  settle_fully_ = plan.steps[step_].visit >= 0;
  enter_step(step);
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
  safe_end_ = std::make_unique<SafeEnd>(reason, std::max(lab_->procedure().end_c, kEnd_c), outputs_off);
  set_state(LabState::stopping, reason);
}

// --- commands ---------------------------------------------------------------------------------------------------

base::Result<nlohmann::json> Engine::command(std::function<base::Result<nlohmann::json>()> work) {
  // Whoever asked finds the new state when the answer is there.
  std::packaged_task<base::Result<nlohmann::json>()> task([this, done = std::move(work)] {
    auto result = done();
    published_ = {};
    publish();
    return result;
  });
  auto answer = task.get_future();
  {
    const std::lock_guard lock(command_mutex_);
    if (stopped_) return tl::unexpected<base::Error>(wrong_state("soakd is ending"));
    commands_.push_back(std::move(task));
  }
  wake();
  return answer.get();
}

void Engine::serve_commands() {
  while (true) {
    std::packaged_task<base::Result<nlohmann::json>()> task;
    {
      const std::lock_guard lock(command_mutex_);
      if (commands_.empty()) return;
      task = std::move(commands_.front());
      commands_.pop_front();
    }
    task();
  }
}

base::Status Engine::ready_for_start() const {
  if (stop_requested_) return tl::unexpected<base::Error>(wrong_state("soakd is ending"));
  if (journal_is_behind_) return tl::unexpected<base::Error>(wrong_state("the journal cannot be written"));
  if (state_ == LabState::stopping) {
    return tl::unexpected<base::Error>(
        wrong_state(fmt::format("campaign '{}' is on its way to the safe state: wait for it", lab_->campaign.name)));
  }
  if (state_ == LabState::running || state_ == LabState::paused) {
    return tl::unexpected<base::Error>(wrong_state(
        fmt::format("campaign '{}' is {}: wait for its end or abort it", lab_->campaign.name, name_of(state_))));
  }
  return {};
}

base::Result<nlohmann::json> Engine::start(const StartRequest& request) {
  return command([this, request] { return do_start(request, std::nullopt); });
}

base::Result<nlohmann::json> Engine::do_start(const StartRequest& request, std::optional<std::size_t> resume_at) {
  if (auto ready = ready_for_start(); !ready) return base::forward_error(ready);
  if (auto entered = enter_lost_runs(catalog_, log_); !entered) return base::forward_error(entered);
  auto checked = check_start(request, config_, catalog_);
  if (!checked) return base::forward_error(checked);
  if (auto connected = connect_devices(); !connected) return base::forward_error(connected);
  const std::size_t first_step = resume_at.value_or(0);
  const double air_c = lab_->chamber.reading()->air_c;
  for (const base::Status& able :
       {check_chamber(*checked, *chamber_), check_disk(*checked, first_step, catalog_.data_folder()),
        check_room(*checked, first_step, config_.room_c, air_c)}) {
    if (!able) return base::forward_error(able);
  }
  // The pre-flight leaves the chamber alone.
  if (checked->plan.runs[static_cast<std::size_t>(checked->plan.steps[first_step].run)].preflight) {
    if (auto off = chamber_->stop(); !off) return base::forward_error(off);
  }
  if (!resume_at) {
    db::CampaignRow row;
    row.name = request.campaign;
    row.procedure = checked->plan.procedure.name;
    row.document = start_document(request, *checked).dump();
    row.created_utc_s = row.updated_utc_s = now_utc_s();
    if (auto begun = catalog_.begin_campaign(row); !begun) return base::forward_error(begun);
  }
  nlohmann::json answer = {{"campaign", request.campaign},
                           {"runs", checked->plan.runs.size()},
                           {"steps", checked->plan.steps.size()},
                           {"estimate_s", checked->plan.remaining_s(first_step)}};
  begin_campaign(request, *std::move(checked), resume_at);
  return answer;
}

base::Status Engine::connect_devices() {
  if (auto status = chamber_->connect(); !status) return status;
  if (fixture_) {
    if (auto status = fixture_->connect(); !status) return status;
  }
  if (power_) {
    if (auto status = power_->connect(); !status) return status;
  }
  // Nothing may begin before the chamber has once said how it is.
  lab_->chamber.forget();
  (void)lab_->chamber.poll(lab_->now_s());
  if (lab_->chamber.stale())
    return base::fail(base::ErrorKind::device, lab_->chamber.trouble(), chamber_->description());
  return {};
}

void Engine::begin_campaign(const StartRequest& request, CheckedStart checked, std::optional<std::size_t> resume_at) {
  make_units(checked);
  std::vector<std::string> serials;
  for (const CheckedUnit& unit : checked.units) serials.push_back(unit.serial);
  history_.begin(std::move(serials));
  lab_->campaign = {request.campaign, request.user, std::move(checked.plan)};
  lab_->preflight.clear();
  step_attempts_.clear();
  if (const auto done = catalog_.completed_steps(request.campaign)) {
    for (const db::StepRow& row : *done) ++step_attempts_[static_cast<std::size_t>(row.index)];
  }
  unfinished_.clear();
  settle_fully_ = false;
  stale_since_.reset();
  campaign_started_utc_s_ = now_utc_s();
  {
    const std::lock_guard lock(status_mutex_);
    plan_document_ = plan_document(lab_->campaign.plan);
  }
  set_state(LabState::running, (resume_at ? "resumed by " : "started by ") + request.user);
  enter_step(resume_at.value_or(0));
}

base::Status Engine::pause(const std::string& user) {
  const auto done = command([this, user]() -> base::Result<nlohmann::json> {
    if (state_ == LabState::paused) return tl::unexpected<base::Error>(wrong_state("the campaign is paused already"));
    if (state_ != LabState::running) return tl::unexpected<base::Error>(wrong_state("no campaign is running"));
    lab_->break_segment("paused by " + user);
    set_state(LabState::paused, "paused by " + user);
    return nlohmann::json();
  });
  return done ? base::Status{} : base::forward_error(done);
}

base::Status Engine::resume(const std::string& user) {
  const auto done = command([this, user] { return do_resume(user); });
  return done ? base::Status{} : base::forward_error(done);
}

base::Result<nlohmann::json> Engine::do_resume(const std::string& user) {
  if (state_ == LabState::paused) {
    set_state(LabState::running, "resumed by " + user);
    repeat_step("resumed");
    return nlohmann::json();
  }
  if (unfinished_.empty() || (state_ != LabState::interrupted && state_ != LabState::failed)) {
    return tl::unexpected<base::Error>(wrong_state("there is no campaign that was paused, interrupted or failed"));
  }
  const auto row = catalog_.campaign(unfinished_);
  if (!row) return base::forward_error(row);
  if (!*row) return tl::unexpected<base::Error>(wrong_state("the journal has no campaign '" + unfinished_ + "'"));
  auto request = request_of(**row);
  if (!request) return base::forward_error(request);
  request->user = user;
  const auto step = first_step_to_resume(catalog_, **row, config_.room_c);
  if (!step) return base::forward_error(step);
  return do_start(*request, *step);
}

base::Status Engine::abort(const std::string& user, const std::string& reason) {
  const auto done = command([this, user, reason]() -> base::Result<nlohmann::json> {
    if (state_ == LabState::interrupted && !unfinished_.empty()) {
      set_state(LabState::aborted, fmt::format("aborted by {}: {}", user, reason));
      return nlohmann::json();
    }
    if (state_ != LabState::running && state_ != LabState::paused) {
      return tl::unexpected<base::Error>(wrong_state("no campaign is running"));
    }
    end_campaign(LabState::aborted, fmt::format("aborted by {}: {}", user, reason));
    return nlohmann::json();
  });
  return done ? base::Status{} : base::forward_error(done);
}

base::Status Engine::confirm(const std::string& user, std::int64_t prompt) {
  const auto done = command([this, user, prompt]() -> base::Result<nlohmann::json> {
    if (!lab_->prompts.answer(prompt)) {
      return tl::unexpected<base::Error>(wrong_state("there is no such prompt (any more): look again"));
    }
    log_.add("prompt", lab_->campaign.name, fmt::format("confirmed by {}: {}", user, lab_->prompts.open()->text));
    return nlohmann::json();
  });
  return done ? base::Status{} : base::forward_error(done);
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

}  // namespace soak::station
