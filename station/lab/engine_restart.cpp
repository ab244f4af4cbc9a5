// SPDX-License-Identifier: Apache-2.0
// What one soakd leaves to the next, and what that does with it.
#include <fmt/format.h>

#include <utility>

#include "station/io/host.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

constexpr std::chrono::seconds kEntryOfResume{2};  ///< for which a try to resume waits for the catalog

}  // namespace

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
  // What an older soakd has entered since, which knew of no note, counts as well.
  note_.goes_on = note_.goes_on && (*open)->state == name_of(CampaignState::running);
  if (note_ != notes_.found().note) notes_.keep(note_);
  const bool was_cut_short = outcome_ == CampaignState::interrupted;
  const std::string reason = was_cut_short ? "soakd ended during the campaign" : note_.reason;
  resumes_by_itself_ = was_cut_short && note_.goes_on;
  log_.add("campaign", station_->campaign.name,
           fmt::format("soakd ended before the campaign did; the chamber is driven to the safe state, then {}",
                       resumes_by_itself_ ? "it goes on"
                       : was_cut_short    ? "'soak campaign resume' can continue it"
                                          : fmt::format("it is {}", name_of(outcome_))));
  restore_units(**open);
  safe_end_ = std::make_unique<SafeEnd>(reason, station_->procedure().end_c, note_.outputs_off,
                                        outcome_ == CampaignState::aborted);
  // Reading what was recorded may take minutes: the chamber comes first.
  runs_are_lost_ = true;
  set_state(CampaignState::stopping, reason, was_cut_short ? "" : std::string(note_.user));
  return {};
}

/// How the last campaign ended, where it did not come to the end of its plan: it may be resumed, or may have left units
/// cold, which nobody knows of after an abort either.
base::Status Engine::restore_unfinished() {
  const auto last = catalog_.last_campaign();
  if (!last) return base::forward_error(last);
  if (*last && (*last)->state == "aborted") {
    state_ = CampaignState::aborted;
    reason_ = (*last)->reason;
    station_->campaign.name = (*last)->name;
    if (note_.campaign == (*last)->name) state_user_ = note_.user;
    return {};
  }
  if (!*last || ((*last)->state != "interrupted" && (*last)->state != "failed")) return {};
  state_ = (*last)->state == "failed" ? CampaignState::failed : CampaignState::interrupted;
  reason_ = (*last)->reason;
  unfinished_ = station_->campaign.name = (*last)->name;
  resumes_by_itself_ = state_ == CampaignState::interrupted && note_.campaign == unfinished_ && note_.goes_on;
  next_resume_s_ = station_->now_s() + kGrace_s;
  return {};
}

void Engine::resume_by_itself() {
  if (station_->now_s() < next_resume_s_) return;
  const auto entered = station_->enter_left_runs();
  if (entered && !*entered) return;  // beside this thread: the next turn asks again
  next_resume_s_ = station_->now_s() + kGrace_s;
  const auto resumed = entered ? try_to_resume() : base::forward_error(entered);
  if (resumed) return;
  const base::Error& error = resumed.error();
  // A device may still be starting, as the computer was, or the catalog be locked. A refusal of the plan is for people.
  resumes_by_itself_ = error.kind != base::ErrorKind::bad_input;
  const std::string trouble =
      fmt::format("{}: {}: {}", resumes_by_itself_ ? "cannot be resumed yet" : "is not resumed, it waits for somebody",
                  error.where, error.message);
  if (trouble != resume_trouble_) log_.add("campaign", unfinished_, trouble);
  resume_trouble_ = trouble;
}

base::Status Engine::try_to_resume() {
  if (!is_recent_break(interrupted_utc_s_, now_utc_s())) {
    return base::bad_input(fmt::format("it was interrupted more than {:.0f} h ago", kLongestBreak_s / 3600.0),
                           "campaign");
  }
  if (!journal_->wait_until_written(kEntryOfResume)) {
    return base::fail(base::ErrorKind::internal, journal_->standing().trouble, "journal");
  }
  if (auto connected = connect_devices(); !connected) return connected;
  // This soakd, or the one before it, had switched it off.
  if (station_->chamber.reading()->running) {
    return base::bad_input("heating and cooling are on: somebody uses it", chamber_->description());
  }
  return do_resume("soakd");
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

bool Engine::runs_of_predecessor_are_entered() {
  if (!runs_are_lost_) return true;
  const bool is_aborted = outcome_ == CampaignState::aborted;
  const auto entered = station_->enter_left_runs(is_aborted ? station_->campaign.name : "");
  if (entered && !*entered) return false;
  runs_are_lost_ = false;
  if (!entered) {
    log_.add("run", station_->campaign.name,
             "what was recorded cannot be entered into the catalog: " + entered.error().message);
  }
  return true;
}

// --- what the next soakd is to know ------------------------------------------------------------------------------

CampaignNote Engine::note_now() const {
  CampaignNote note{.campaign = station_->campaign.name};
  switch (state_) {
    case CampaignState::running:
    case CampaignState::suspended:
      // Somebody who is asked for something may have the door open.
      note.goes_on = has_come_on_ && station_->procedure().on_restart == RestartOutcome::resume && !was_asking_ &&
                     !station_->prompts.open();
      return note;
    case CampaignState::stopping:
      if (outcome_ != CampaignState::interrupted) return ended_note(outcome_);
      note.outputs_off = safe_end_ && safe_end_->outputs_off();
      [[fallthrough]];
    case CampaignState::interrupted:
      // As it stood before soakd was to end, unless somebody has decided otherwise since.
      note.goes_on = note_.goes_on && note_.campaign == note.campaign && (resumes_by_itself_ || stop_requested_);
      return note;
    case CampaignState::idle:
      return note_;
    case CampaignState::aborted:
    case CampaignState::failed:
      return ended_note(state_);  // the catalog may not have it yet
    case CampaignState::paused:
    case CampaignState::finished:
      break;
  }
  return note;
}

CampaignNote Engine::ended_note(CampaignState outcome) const {
  return {.campaign = station_->campaign.name,
          .outputs_off = safe_end_ ? safe_end_->outputs_off() : note_.outputs_off,
          .outcome = std::string(name_of(outcome)),
          .reason = reason_,
          .user = state_user_};
}

void Engine::keep_note() {
  const CampaignNote note = note_now();
  if (note == note_) return;
  note_ = note;
  notes_.keep(note);
}

}  // namespace soak::station
