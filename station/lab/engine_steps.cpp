// SPDX-License-Identifier: Apache-2.0
// The engine's way from step to step, and from state to state.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cassert>
#include <utility>

#include "station/io/host.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kEntryIsWritten{100};
constexpr std::chrono::seconds kEntryInterval{5};  ///< between tries to enter what the catalog has refused
/// For a campaign that has come to its end nothing waits: who reads of it shall find it in the catalog.
constexpr std::chrono::milliseconds kEndIsWritten{1000};

/// Steps for which temperature and position were judged. A break makes these judgements void.
bool needs_judgement(StepKind kind) {
  return kind == StepKind::move || kind == StepKind::spin || kind == StepKind::set_temperature ||
         kind == StepKind::wait_stable || kind == StepKind::record;
}

}  // namespace

// --- from step to step ------------------------------------------------------------------------------------------

void Engine::enter_step(std::size_t index) {
  const Plan& plan = station_->campaign.plan;
  step_ = index;
  step_started_utc_s_ = now_utc_s();
  step_started_s_ = station_->now_s();
  station_->prompts.withdraw();
  if (air_may_leave(plan.steps[index])) air_has_arrived_ = false;
  Step step = plan.steps[index];
  if (step.kind == StepKind::wait_stable && std::exchange(settle_fully_, false)) step.after_turn = false;
  task_ = make_task(plan, step);
  forget_end_of_step();
  published_ = {};
}

bool Engine::air_may_leave(const Step& step) const {
  return step.kind == StepKind::set_temperature || (step.kind == StepKind::move && fixture_ == nullptr);
}

void Engine::forget_end_of_step() {
  ended_.reset();
  ended_row_.reset();
  ticket_.reset();
  step_error_.clear();
  broken_.reset();
}

void Engine::advance() {
  if (!ended_) {
    if (nothing_is_left_to_record()) return end_campaign(CampaignState::failed, std::string(kNothingLeft));
    const StepProgress progress = task_->poll(*station_);
    if (progress.state == StepState::running) return;
    if (progress.state == StepState::failed) return step_failed(progress);
    if (!progress.text.empty()) log_.add("step", describe(station_->campaign.plan, step_), progress.text);
    ended_ = progress;
  }
  if (step_is_stored()) leave_step();
}

void Engine::step_failed(const StepProgress& progress) {
  log_.add("step", describe(station_->campaign.plan, step_), "failed: " + progress.text);
  journal_->add(step_row("failed", progress.text));
  end_campaign(CampaignState::failed,
               progress.error.where.empty() ? progress.text : progress.error.where + ": " + progress.text);
}

/// Rows first: a step whose end the journal knows must not lose them.
bool Engine::step_is_stored() {
  if (!ended_row_) {
    if (const auto flushed = station_->flush(); !flushed) {
      storage_error_ = flushed.error().message;
      return false;
    }
    ended_row_ = step_row(ended_->state == StepState::skip_visit ? "skipped" : "done", ended_->text);
    ticket_ = journal_->add(*ended_row_);
    // As a rule it is there within some milliseconds: the next step then follows without a turn of the loop between.
    (void)journal_->wait_until_written(kEntryIsWritten);
  }
  return follow_end_of_step() == Journal::Written::yes;
}

/// What cannot be entered is tried again: by the journal, or, where the catalog refused it, from here.
Journal::Written Engine::follow_end_of_step() {
  if (!ticket_) return Journal::Written::not_yet;
  const Journal::Written written = journal_->written(*ticket_);
  switch (written) {
    case Journal::Written::yes:
      step_error_.clear();
      break;
    case Journal::Written::not_yet:
      // After a refusal the reason stands until the next try has come to its end.
      if (const auto trouble = journal_->standing().trouble; !trouble.empty()) step_error_ = trouble;
      break;
    case Journal::Written::refused:
      step_error_ = journal_->refusal();
      if (steady_clock::now() < next_entry_) break;
      next_entry_ = steady_clock::now() + kEntryInterval;
      ticket_ = journal_->add(*ended_row_);
      break;
  }
  return written;
}

/// A plan has so many steps: what is allowed again after each of them cannot go on for ever.
void Engine::note_progress() {
  has_come_on_ = true;
  set_point_repeats_ = 0;
  suspenders_.note_progress();
}

db::StepRow Engine::step_row(const std::string& outcome, const std::string& text) {
  db::StepRow row;
  row.campaign = station_->campaign.name;
  row.index = static_cast<std::int32_t>(step_);
  row.attempt = step_attempts_[step_]++;
  row.started_utc_s = step_started_utc_s_;
  row.ended_utc_s = now_utc_s();
  row.outcome = outcome;
  row.text = text;
  row.run_id = station_->run_id();
  return row;
}

void Engine::leave_step() {
  const auto broken = broken_;
  was_asking_ = false;
  if (ended_row_->attempt == 0) note_progress();
  const bool was_on_way_back = is_on_way_back();
  const int visit = station_->campaign.plan.steps[step_].visit;
  enter_next_step();
  if (!was_on_way_back && task_ && station_->campaign.plan.steps[step_].visit != visit) forget_way();
  if (!broken || !task_) return;
  const int next_visit = station_->campaign.plan.steps[step_].visit;
  const bool begins_visit = !was_on_way_back && next_visit >= 0 && next_visit != visit;
  begins_visit ? go_to_visit(air_was_away_) : repeat_step(*broken);
}

/// With the visit that a resumed campaign went back to its way is over, and nothing more to be said of it.
void Engine::forget_way() {
  if (reason_behind_way_ && state_ == CampaignState::running) reason_ = *reason_behind_way_;
  reason_behind_way_.reset();
}

/// Goes to the begin of the present visit from wherever the air is, approached as the plan does.
void Engine::go_to_visit(bool air_was_away) {
  const auto& reading = station_->chamber.reading();
  const double air_c = reading ? reading->air_c : config_.room_c;
  way_back_ = way_to_visit(station_->campaign.plan, step_, {air_c, config_.room_c, air_was_away});
  way_at_ = 0;
  settle_fully_ = false;
  enter_step(way_back_.front());
}

void Engine::enter_next_step() {
  const Plan& plan = station_->campaign.plan;
  const bool skip = ended_->state == StepState::skip_visit;
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
    finish();
  }
}

void Engine::finish() {
  // It may have tripped since this turn began: such a campaign has not finished.
  if (const std::string tripped = watch_ ? watch_->verdict().tripped : ""; !tripped.empty()) {
    return switch_off_chamber(tripped);
  }
  task_.reset();
  step_ = station_->campaign.plan.steps.size();
  const auto& missing = station_->campaign.missing_units;
  set_state(CampaignState::finished, missing.empty() ? "" : fmt::format("without {}", fmt::join(missing, ", ")));
}

double Engine::left_from_s(std::size_t at) const {
  const Plan& plan = station_->campaign.plan;
  if (!is_on_way_back()) return plan.remaining_s(at);
  double seconds = plan.remaining_s(way_back_.back() + 1);
  for (std::size_t i = at; i < way_back_.size(); ++i) seconds += plan.steps[way_back_[i]].estimate_s;
  return seconds;
}

double Engine::remaining_s() const {
  const Plan& plan = station_->campaign.plan;
  if (step_ >= plan.steps.size()) return 0.0;
  const Step& step = plan.steps[step_];
  const std::size_t here = is_on_way_back() ? way_at_ : step_;
  const bool is_held = state_ == CampaignState::paused || state_ == CampaignState::suspended ||
                       (state_ == CampaignState::running && chamber_is_silent_);
  if (is_held && !ended_) {
    if (visit_is_void_ && begins_anew(step)) return left_from_s(here);
    if (visit_is_void_ || needs_judgement(step.kind)) return left_from_s(begins_again_at());
  }
  const bool goes_on = is_held || state_ == CampaignState::running;
  const double in_step_s = goes_on ? std::max(0.0, station_->now_s() - step_started_s_) : 0.0;
  return left_from_s(here + 1) + std::max(0.0, step.estimate_s - in_step_s);
}

std::size_t Engine::begins_again_at() const {
  const Plan& plan = station_->campaign.plan;
  if (is_on_way_back()) {
    std::size_t at = way_at_;
    while (at > 0 && needs_judgement(plan.steps[way_back_[at - 1]].kind)) --at;
    return at;
  }
  const Step& here = plan.steps[step_];
  const auto same_visit = [&](std::size_t other) {
    return plan.steps[other].run == here.run && plan.steps[other].visit == here.visit;
  };
  std::size_t at = step_;
  if (visit_is_void_ && here.visit >= 0) {
    while (at > 0 && same_visit(at - 1)) --at;
    return at;
  }
  while (at > 0 && plan.steps[at].kind != StepKind::move && same_visit(at - 1) &&
         needs_judgement(plan.steps[at - 1].kind)) {
    --at;
  }
  return at;
}

void Engine::repeat_step(const std::string& why) {
  const Plan& plan = station_->campaign.plan;
  station_->break_segment(why);
  // A step that is complete and waits for its entry stays so; what follows it is judged anew.
  if (ended_) {
    broken_ = why;
    return;
  }
  if (!needs_judgement(plan.steps[step_].kind)) return;
  const std::size_t at = begins_again_at();
  if (is_on_way_back()) {
    way_at_ = at;
    enter_step(way_back_[at]);
    return;
  }
  settle_fully_ = plan.steps[step_].visit >= 0;
  enter_step(at);
}

/// Whether a step that was suspended is to begin again though nothing was judged for it: its question, or the time that
/// it may take, is over.
bool Engine::begins_anew(const Step& step) const {
  if (ended_) return false;
  if (step.kind == StepKind::power_on) return !station_->run_is_open();
  return step.kind == StepKind::turn_fixture || step.kind == StepKind::warm_end;
}

void Engine::repeat_visit() {
  const Plan& plan = station_->campaign.plan;
  visit_is_void_ = false;
  const Step& step = plan.steps[step_];
  if (begins_anew(step)) return enter_step(step_);
  // A visit whose last step is complete, and waits for its entry, is not measured twice.
  const bool is_complete =
      ended_ && (ended_->state == StepState::skip_visit || step_ + 1 >= plan.steps.size() ||
                 plan.steps[step_ + 1].visit != step.visit || plan.steps[step_ + 1].run != step.run);
  if (step.visit < 0 || is_complete || is_on_way_back()) return repeat_step("the campaign was suspended");
  // Each position is recorded once more: what was complete before would stand beside it.
  station_->withdraw_visit(step.visit, "the campaign was suspended, its visit begins again");
  go_to_visit(air_was_away_);
}

// --- states -----------------------------------------------------------------------------------------------------

void Engine::show_state(CampaignState state, const std::string& reason, const std::string& user) {
  if (!may_follow(state_, state)) {
    log_.add("campaign", station_->campaign.name,
             fmt::format("internal error: no way leads from {} to {}", name_of(state_), name_of(state)));
    assert(false);
  }
  state_ = state;
  reason_ = reason;
  state_user_ = user;
  reason_behind_way_.reset();  // of the state before
  log_.add("campaign", station_->campaign.name,
           reason.empty() ? std::string(name_of(state)) : fmt::format("{}: {}", name_of(state), reason), user);
  keep_note();
}

void Engine::set_state(CampaignState state, const std::string& reason, const std::string& user) {
  show_state(state, reason, user);
  // While it is suspended or on the way to the safe state the journal's campaign stays open: if soakd ends now, the
  // next one takes it over.
  if (state == CampaignState::stopping || state == CampaignState::suspended) return;
  const std::string& campaign = station_->campaign.name;
  journal_->add(Journal::State{campaign, std::string(journal_name_of(state)), reason, user});
  if (is_under_way(state)) return;
  unfinished_ = is_resumable(state) ? campaign : "";
  follow_with_queue(state);
  for (const auto& unit : station_->units) unit->close();
  (void)journal_->wait_until_written(kEndIsWritten);
}

void Engine::follow_safe_end() {
  const bool is_safe = safe_end_->poll(*station_);
  // What goes wrong on the way is for people: nothing goes on after it by itself.
  if (const std::string trouble = safe_end_->trouble(); !trouble.empty() && outcome_ == CampaignState::interrupted) {
    outcome_ = CampaignState::failed;
    resumes_by_itself_ = false;
    set_state(CampaignState::stopping, trouble);
  }
  if (!is_safe || !runs_of_predecessor_are_entered()) return;
  safe_end_.reset();
  next_resume_s_ = station_->now_s() + kGrace_s;
  set_state(outcome_, std::string(reason_), std::string(state_user_));
}

void Engine::end_campaign(CampaignState outcome, const std::string& reason, bool outputs_off, const std::string& user) {
  if (!is_under_way(state_)) return;
  // A chamber that is being switched off at the end of the campaign, and does not go off, is not driven again.
  outputs_off = outputs_off || !step_trouble().empty();
  task_.reset();
  forget_end_of_step();
  station_->prompts.withdraw();
  station_->chamber.expect(std::nullopt);
  chamber_is_silent_ = false;
  outcome_ = outcome;
  safe_end_ =
      std::make_unique<SafeEnd>(reason, station_->procedure().end_c, outputs_off, outcome == CampaignState::aborted);
  set_state(CampaignState::stopping, reason, user);
  // The chamber comes first: whatever else is to be done may take time.
  (void)safe_end_->poll(*station_);
  station_->break_segment(reason);
  station_->set_plateau(std::nullopt, calib::Sweep::unknown, -1);
}

}  // namespace soak::station
