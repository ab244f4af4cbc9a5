// SPDX-License-Identifier: Apache-2.0
// What people ask of the engine. Every command runs on the engine's own thread.
#include <fmt/format.h>

#include <thread>
#include <utility>

#include "station/io/host.h"
#include "station/lab/engine.h"
#include "station/lab/start_check.h"
#include "station/lab/stored.h"

namespace soak::station {
namespace {

constexpr std::chrono::milliseconds kAskAgain{20};
constexpr double kSecondsPerHour = 3600.0;
constexpr std::chrono::milliseconds kCommandIsWritten{200};
constexpr std::chrono::seconds kJournalIsWritten{2};
constexpr std::chrono::seconds kNoteIsKept{2};
/// An engine that does not take an abort for so long is stuck: the chamber's watch then switches heating and cooling
/// off.
constexpr std::chrono::seconds kEngineIsStuck{30};

/// Counts an abort or a pause for as long as it is not answered.
class StopCommand {
 public:
  explicit StopCommand(std::atomic<int>& count) : count_(count) { ++count_; }
  StopCommand(const StopCommand&) = delete;
  StopCommand& operator=(const StopCommand&) = delete;
  ~StopCommand() { --count_; }

 private:
  std::atomic<int>& count_;
};

std::string reason_of_start(const StartRequest& request, const std::optional<WayBack>& resumed) {
  const std::string way = resumed && !resumed->text.empty() ? "; " + resumed->text : "";
  return fmt::format("{} {}{}", resumed ? "resumed" : "started", begun_by(request.user, request.queued_by), way);
}

tl::unexpected<base::Error> wrong_state(std::string message) { return base::bad_input(std::move(message), "state"); }

}  // namespace

base::Result<nlohmann::json> Engine::command(std::function<base::Result<nlohmann::json>()> work,
                                             const std::function<void()>& late) {
  // Who gets the answer also finds the new state published.
  std::packaged_task<base::Result<nlohmann::json>()> task([this, done = std::move(work)] {
    auto result = done();
    published_ = {};
    publish();
    return result;
  });
  auto answer = task.get_future();
  {
    const std::lock_guard lock(command_mutex_);
    if (stopped_) return wrong_state("soakd is stopping");
    commands_.push_back(std::move(task));
  }
  wake();
  if (answer.wait_for(kEngineIsStuck) != std::future_status::ready) late();
  auto result = answer.get();
  // Who asked finds it in the catalog, too, where that is not locked, and what they have decided outlives soakd. The
  // engine does not wait for that.
  (void)journal_->wait_until_written(kCommandIsWritten);
  (void)notes_.wait_until_kept(kNoteIsKept);
  return result;
}

void Engine::run_commands() {
  // What comes meanwhile waits for the next turn: however many ask, the chamber is supervised between them.
  std::deque<std::packaged_task<base::Result<nlohmann::json>()>> due;
  {
    const std::lock_guard lock(command_mutex_);
    due.swap(commands_);
  }
  for (auto& task : due) task();
}

base::Status Engine::status_command(std::function<base::Status()> work, const std::function<void()>& late) {
  const auto done = command(
      [work = std::move(work)]() -> base::Result<nlohmann::json> {
        if (auto status = work(); !status) return base::forward_error(status);
        return nlohmann::json();
      },
      late);
  return done ? base::Status{} : base::forward_error(done);
}

base::Status Engine::pause(const std::string& user) {
  const StopCommand stop(stop_commands_);
  notes_.withdraw();  // now: should the engine be stuck, and soakd be killed for that, this counts
  return status_command([=, this] { return do_pause(user); });
}

base::Status Engine::resume(const std::string& user) {
  const auto done = command_after_left_runs([=, this]() -> base::Result<nlohmann::json> {
    if (auto status = do_resume(user); !status) return base::forward_error(status);
    return nlohmann::json();
  });
  return done ? base::Status{} : base::forward_error(done);
}

base::Status Engine::abort(const std::string& user, const std::string& reason) {
  const StopCommand stop(stop_commands_);
  notes_.withdraw();
  const auto stop_chamber = [&] {
    if (watch_) watch_->stop_now(fmt::format("aborted by {}, and soakd itself does not turn", user));
  };
  return status_command([=, this] { return do_abort(user, reason); }, stop_chamber);
}

base::Status Engine::confirm(const std::string& user, std::int64_t prompt) {
  return status_command([=, this] { return do_confirm(user, prompt); });
}

base::Result<nlohmann::json> Engine::stored() {
  return command([this] { return stored_document(config_, catalog_); });
}

// --- starting ---------------------------------------------------------------------------------------------------

base::Status Engine::ready_for_start() const {
  if (stop_requested_) return wrong_state("soakd is stopping");
  if (is_held_) return wrong_state(std::string(kHeld));
  if (looks_into_slots_) return wrong_state("somebody is looking into the slots: try again in some seconds");
  if (state_ == CampaignState::stopping) {
    return wrong_state(
        fmt::format("campaign '{}' is being brought to the safe state: wait for it", station_->campaign.name));
  }
  if (!can(state_, CampaignEvent::start)) {
    return wrong_state(
        fmt::format("campaign '{}' is {}: wait for its end or abort it", station_->campaign.name, name_of(state_)));
  }
  if (const std::string trouble = data_folder_.trouble(); !trouble.empty()) {
    return base::fail(base::ErrorKind::internal, trouble + ": bring it back, or start soakd again", kNoFolder);
  }
  // The catalog is used directly from here on: what came before must be in it.
  if (!journal_->wait_until_written(kJournalIsWritten)) {
    const std::string trouble = journal_->standing().trouble;
    return wrong_state(trouble.empty() ? "what came before is still being written: try again in a moment"
                                       : "the journal cannot be written: " + trouble);
  }
  return {};
}

base::Status Engine::hold_for_settings() {
  return status_command([this] { return begin_hold(); });
}

void Engine::end_hold() {
  (void)status_command([this]() -> base::Status {
    is_held_ = false;
    return {};
  });
}

base::Status Engine::begin_hold() {
  if (stop_requested_) return wrong_state("soakd is stopping");
  if (is_held_) return wrong_state(std::string(kHeld));
  if (looks_into_slots_) return wrong_state("somebody is looking into the slots: try again in some seconds");
  const bool is_over = state_ == CampaignState::idle || state_ == CampaignState::finished ||
                       state_ == CampaignState::aborted || state_ == CampaignState::failed;
  if (!is_over) {
    return wrong_state(fmt::format("campaign '{}' is {}: settings are changed after its end, or abort it",
                                   unfinished_.empty() ? station_->campaign.name : unfinished_, name_of(state_)));
  }
  if (const auto first = queue_.front()) {
    return wrong_state(fmt::format("campaign '{}' is in the queue: settings are changed after its end, or take it out",
                                   first->request.campaign));
  }
  is_held_ = true;
  return {};
}

base::Result<nlohmann::json> Engine::start(const StartRequest& request) {
  return command_after_left_runs([this, request]() -> base::Result<nlohmann::json> {
    if (queue_.holds(request.campaign)) {
      return base::bad_input(
          fmt::format("campaign '{}' is in the queue: 'soak campaign unqueue' takes it out", request.campaign),
          "campaign");
    }
    return do_start(request, std::nullopt);
  });
}

base::Result<nlohmann::json> Engine::command_after_left_runs(
    const std::function<base::Result<nlohmann::json>()>& work) {
  while (true) {
    bool waits = false;
    auto answer = command([&]() -> base::Result<nlohmann::json> {
      if (ready_for_start()) {
        const auto entered = station_->enter_left_runs();
        if (!entered) return base::forward_error(entered);
        waits = !*entered;
      }
      return waits ? base::Result<nlohmann::json>(nlohmann::json()) : work();
    });
    if (!waits) return answer;
    std::this_thread::sleep_for(kAskAgain);
  }
}

base::Result<nlohmann::json> Engine::do_start(const StartRequest& request, const std::optional<WayBack>& resumed) {
  if (auto ready = ready_for_start(); !ready) return base::forward_error(ready);
  auto checked = check_start(request, config_, catalog_);
  if (!checked) return base::forward_error(checked);
  const std::size_t first_step = resumed ? resumed->steps.front() : 0;
  const auto judged = check_references(catalog_, *checked, first_step, now_utc_s(), config_.clock_rate);
  if (!judged) return base::forward_error(judged);
  const auto standards = note_on_check_standards(catalog_, *checked);
  if (!standards) return base::forward_error(standards);
  if (auto connected = connect_devices(); !connected) return base::forward_error(connected);
  const double air_c = station_->chamber.reading()->air_c;
  for (const base::Status& able : {check_chamber(*checked, *chamber_), check_fixture(*checked, fixture_.get()),
                                   check_disk(*checked, first_step, catalog_.data_folder()),
                                   check_room(*checked, first_step, config_.room_c, air_c)}) {
    if (!able) return base::forward_error(able);
  }
  // The pre-flight leaves the chamber alone.
  if (checked->plan.runs[static_cast<std::size_t>(checked->plan.steps[first_step].run)].preflight) {
    if (auto off = chamber_->stop(); !off) return base::forward_error(off);
  }
  std::vector<std::string> notes = judged->notes;
  if (*standards) notes.push_back(**standards);
  if (auto stored = store_start(request, *checked, judged->uses, notes, resumed); !stored) {
    return base::forward_error(stored);
  }
  nlohmann::json answer = {{"campaign", request.campaign},
                           {"runs", checked->plan.runs.size()},
                           {"steps", checked->plan.steps.size()},
                           {"estimate_s", checked->plan.remaining_s(first_step)},
                           {"notes", std::move(notes)}};
  begin_campaign(request, *std::move(checked), resumed);
  for (const std::string& note : judged->notes) log_.add("reference", request.campaign, note);
  if (*standards) log_.add("check_standard", request.campaign, **standards);
  return answer;
}

base::Status Engine::store_start(const StartRequest& request, const CheckedStart& checked,
                                 const std::vector<calib::ReferenceUse>& references,
                                 const std::vector<std::string>& notes, const std::optional<WayBack>& resumed) {
  db::CampaignRow row;
  row.name = request.campaign;
  row.procedure = checked.plan.procedure.name;
  row.document = start_document(request, checked, notes).dump();
  row.created_utc_s = row.updated_utc_s = now_utc_s();
  return catalog_.all_or_nothing([&]() -> base::Status {
    if (!resumed) {
      if (auto begun = catalog_.begin_campaign(row); !begun) return begun;
    }
    // Not by way of the journal: were soakd killed before that has written it, the next one would take a resumed
    // campaign for one that is in the safe state, and leave chamber and units as they are.
    const std::string reason = reason_of_start(request, resumed);
    const auto running = journal_name_of(CampaignState::running);
    if (auto open = catalog_.set_campaign_state(request.campaign, running, reason, request.user); !open) return open;
    // Now, while nothing runs yet: a run that begins need not wait for the catalog.
    for (const CheckedUnit& unit : checked.units) {
      if (auto entered = catalog_.ensure_unit(unit.serial, unit.type.name); !entered) {
        return base::forward_error(entered);
      }
    }
    return catalog_.add_campaign_references(request.campaign, references);
  });
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
  station_->chamber.forget();
  (void)station_->chamber.poll(station_->now_s());
  if (station_->chamber.stale())
    return base::fail(base::ErrorKind::device, station_->chamber.trouble(), chamber_->description());
  return {};
}

void Engine::begin_campaign(const StartRequest& request, CheckedStart checked, const std::optional<WayBack>& resumed) {
  guard_.forget();
  if (watch_) watch_->disarm();
  make_units(checked);
  std::vector<std::string> serials;
  for (const CheckedUnit& unit : checked.units) serials.push_back(unit.serial);
  history_.begin(std::move(serials));
  station_->campaign = {request.campaign, begun_by(request.user, request.queued_by), std::move(checked.plan)};
  station_->preflight.clear();
  step_attempts_.clear();
  if (const auto done = catalog_.completed_steps(request.campaign)) {
    for (const db::StepRow& row : *done) ++step_attempts_[static_cast<std::size_t>(row.index)];
  }
  unfinished_.clear();
  settle_fully_ = false;
  suspenders_ = Suspenders(station_->procedure().give_up_h * kSecondsPerHour);
  chamber_is_silent_ = visit_is_void_ = air_was_away_ = air_has_arrived_ = chamber_is_left_alone_ = false;
  set_point_repeats_ = 0;
  has_come_on_ = was_asking_ = false;
  allow_to_go_on();
  resumes_by_itself_ = false;
  resume_trouble_.clear();
  storage_error_.clear();
  next_disk_look_ = {};
  campaign_started_utc_s_ = now_utc_s();
  {
    const std::lock_guard lock(status_mutex_);
    plan_document_ = plan_document(station_->campaign.plan);
  }
  way_back_ = resumed ? resumed->steps : std::vector<std::size_t>{0};
  way_at_ = 0;
  show_state(CampaignState::running, reason_of_start(request, resumed), request.user);
  if (resumed) reason_behind_way_ = reason_of_start(request, WayBack{});
  enter_step(way_back_.front());
}

// --- the other commands -----------------------------------------------------------------------------------------

base::Status Engine::do_pause(const std::string& user) {
  if (state_ == CampaignState::paused) return wrong_state("the campaign is paused already");
  if (!can(state_, CampaignEvent::pause)) return wrong_state("no campaign is running");
  if (const std::string trouble = step_trouble(); !trouble.empty()) return wrong_state(trouble);
  station_->break_segment("paused by " + user);
  // Somebody may open the door.
  if (auto halted = station_->halt_fixture(); !halted) {
    log_.add("device", "fixture", "cannot be halted: " + halted.error().message);
  }
  // Its time-outs go on, and what the units send before the run is open would pile up: it begins again.
  if (!station_->run_is_open() && station_->campaign.plan.steps[step_].kind == StepKind::power_on) {
    void_visit("paused by " + user);
  }
  set_state(CampaignState::paused, "paused by " + user, user);
  return {};
}

void Engine::allow_to_go_on() {
  if (stop_commands_ == 0) notes_.allow();
}

base::Status Engine::do_resume(const std::string& user) {
  if (state_ == CampaignState::paused) {
    // What held while people had the chamber in hand does not count against the campaign.
    suspenders_ = Suspenders(station_->procedure().give_up_h * kSecondsPerHour);
    chamber_is_left_alone_ = false;
    allow_to_go_on();
    set_state(CampaignState::running, "resumed by " + user, user);
    visit_is_void_ ? repeat_visit() : repeat_step("resumed");
    return {};
  }
  if (state_ == CampaignState::stopping) {
    return wrong_state(
        "the chamber is still on its way to the safe state: wait until the state is no longer 'stopping'");
  }
  if (unfinished_.empty() || !is_resumable(state_)) {
    return wrong_state("there is no campaign that was paused, interrupted or failed");
  }
  const auto row = catalog_.campaign(unfinished_);
  if (!row) return base::forward_error(row);
  if (!*row) return wrong_state("the journal has no campaign '" + unfinished_ + "'");
  auto request = request_of(**row);
  if (!request) return base::forward_error(request);
  request->user = user;
  const auto way = way_to_resume(catalog_, **row, config_.room_c);
  if (!way) return base::forward_error(way);
  const auto started = do_start(*request, *way);
  if (started) queue_is_held_ = false;
  return started ? base::Status{} : base::forward_error(started);
}

base::Status Engine::do_abort(const std::string& user, const std::string& reason) {
  const std::string text = fmt::format("aborted by {}: {}", user, reason);
  if (state_ == CampaignState::interrupted && !unfinished_.empty()) {
    resumes_by_itself_ = false;
    set_state(CampaignState::aborted, text, user);
    return {};
  }
  if (state_ == CampaignState::stopping && outcome_ == CampaignState::interrupted) {
    // The way to the safe state is the same; what would come after it is not.
    outcome_ = CampaignState::aborted;
    safe_end_->note_abort(text);
    resumes_by_itself_ = false;
    set_state(CampaignState::stopping, text, user);
    return {};
  }
  if (next_begins_by_itself()) {
    hold_queue();
    log_.add("campaign", station_->campaign.name, fmt::format("{}; the queue waits for somebody", text), user);
    return {};
  }
  if (!is_under_way(state_)) return wrong_state("no campaign is running");
  end_campaign(CampaignState::aborted, text, false, user);
  return {};
}

base::Status Engine::do_confirm(const std::string& user, std::int64_t prompt) {
  if (!station_->prompts.answer(prompt)) {
    return wrong_state("that prompt is no longer open: see 'soak campaign status'");
  }
  log_.add("prompt", station_->campaign.name, fmt::format("confirmed by {}: {}", user, station_->prompts.open()->text),
           user);
  return {};
}

}  // namespace soak::station
