// SPDX-License-Identifier: Apache-2.0
// Campaigns that begin one after another.
#include <fmt/format.h>

#include <utility>

#include "station/io/host.h"
#include "station/lab/engine.h"
#include "station/lab/start_check.h"

namespace soak::station {
namespace {

/// For which the beginning of the next campaign waits for what the last one has left to write.
constexpr std::chrono::seconds kEntryOfNext{2};
/// Process time after the end of a campaign for which the next one is tried: later, somebody may use the chamber.
constexpr double kTryFor_s = 7200.0;

/// Whether time may mend it: a device that does not answer yet, a chamber that is still warm, a catalog that is locked.
bool may_pass(const base::Error& error) { return error.kind != base::ErrorKind::bad_input || error.where == "state"; }

}  // namespace

// --- what people ask --------------------------------------------------------------------------------------------

base::Result<nlohmann::json> Engine::queue(const StartRequest& request) {
  QueuedCampaign queued;
  bool is_first = false;
  auto checked = command([&] {
    is_first = queue_.empty();
    queue_is_held_ = queue_is_held_ || is_first;  // until its notice is given below
    return check_for_queue(request, queued);
  });
  if (!checked) return checked;
  // Written here: the engine does not wait for the disk.
  if (auto added = queue_.add(std::move(queued)); !added) return base::forward_error(added);
  const auto told = status_command([&]() -> base::Status {
    log_.add("campaign", request.campaign, fmt::format("queued by {}", request.user), request.user);
    if (is_first) let_queue_go_on();  // nobody has stopped it
    return {};
  });
  return told ? checked : base::forward_error(told);
}

/// Checks what can be known before it begins: then nobody is here.
base::Result<nlohmann::json> Engine::check_for_queue(const StartRequest& request, QueuedCampaign& queued) {
  if (stop_requested_) return base::bad_input("soakd is stopping", "state");
  if (is_held_) return base::bad_input(std::string(kHeld), "state");
  const auto checked = check_start(request, config_, catalog_);
  if (!checked) return base::forward_error(checked);
  const auto known = catalog_.campaign(request.campaign);
  if (!known) return base::forward_error(known);
  if (*known) {
    return base::bad_input(fmt::format("campaign '{}' exists already: choose another name", request.campaign),
                           "campaign");
  }
  for (const base::Status& able : {check_chamber(*checked, *chamber_), check_fixture(*checked, fixture_.get())}) {
    if (!able) return base::forward_error(able);
  }
  const bool runs = is_under_way(state_);
  const double before_s = queue_.estimate_s() + (runs ? remaining_s() : 0.0);
  const auto judged =
      check_references(catalog_, *checked, 0, now_utc_s() + before_s / config_.clock_rate, config_.clock_rate);
  if (!judged) return base::forward_error(judged);
  queued = {request, checked->plan.procedure.name, checked->plan.remaining_s(0), now_utc_s()};
  return nlohmann::json{{"campaign", request.campaign},
                        {"runs", checked->plan.runs.size()},
                        {"steps", checked->plan.steps.size()},
                        {"estimate_s", queued.estimate_s},
                        {"notes", judged->notes},
                        {"before", queue_.size() + (runs ? 1U : 0U)}};
}

base::Status Engine::unqueue(const std::string& user, const std::string& campaign) {
  if (auto removed = queue_.remove(campaign); !removed) return removed;
  return status_command([=, this]() -> base::Status {
    log_.add("campaign", campaign, "taken out of the queue by " + user, user);
    queue_trouble_.clear();
    return {};
  });
}

base::Status Engine::next(const std::string& user, const std::string& campaign) {
  const auto begun = command_after_left_runs([=, this]() -> base::Result<nlohmann::json> {
    const auto first = queue_.front();
    if (!first) return base::bad_input("no campaign is in the queue", "state");
    if (!campaign.empty() && first->request.campaign != campaign) {
      return base::bad_input(fmt::format("'{}' is no longer the next one, '{}' is", campaign, first->request.campaign),
                             "state");
    }
    return begin_first(*first, user);
  });
  return begun ? base::Status{} : base::forward_error(begun);
}

base::Result<nlohmann::json> Engine::begin_first(const QueuedCampaign& first, const std::string& user) {
  StartRequest request = first.request;
  request.queued_by = std::exchange(request.user, user);
  auto begun = do_start(request, std::nullopt);
  if (!begun) return begun;
  queue_is_held_ = false;
  queue_trouble_.clear();
  // Where the file cannot be written, the next soakd finds the campaign in the catalog.
  if (auto out = queue_.take_out(request.campaign); !out) {
    log_.add("campaign", request.campaign, "cannot be taken out of the queue's file: " + out.error().message);
  }
  return begun;
}

// --- what the station does --------------------------------------------------------------------------------------

/// What a predecessor left in the queue: what has begun is no longer in it, and nothing begins by itself.
void Engine::restore_queue() {
  if (!queue_.trouble().empty()) log_.add("campaign", "queue", queue_.trouble());
  drop_what_has_begun();
  hold_queue();
}

/// Somebody started a campaign of that name, or the file could not be written when it began.
void Engine::drop_what_has_begun() {
  while (const auto first = queue_.front()) {
    const auto known = catalog_.campaign(first->request.campaign);
    if (!known || !*known) return;
    const auto out = queue_.take_out(first->request.campaign);
    log_.add("campaign", first->request.campaign,
             "is no longer in the queue: a campaign of that name has begun" + (out ? "" : "; " + out.error().message));
  }
}

/// The queue waits until somebody begins its next campaign, or resumes the one that was cut short.
void Engine::hold_queue() { queue_is_held_ = !queue_.empty(); }

void Engine::let_queue_go_on() {
  queue_is_held_ = device_was_silent_ = false;
  queue_since_s_ = station_->now_s();
  give_notice();
}

/// People have their time from now on to see what will happen, and to stop it.
void Engine::give_notice() {
  next_begin_s_ = station_->now_s() + kGrace_s;
  next_begin_utc_s_ = now_utc_s() + kGrace_s / config_.clock_rate;
}

/// The next campaign begins by itself only after one that finished with all its units: what else ended needs somebody
/// to look at it.
void Engine::follow_with_queue(CampaignState ended) {
  queue_trouble_.clear();
  if (ended != CampaignState::finished || !station_->campaign.missing_units.empty()) return hold_queue();
  if (!queue_is_held_) let_queue_go_on();
}

bool Engine::next_begins_by_itself() const {
  return state_ == CampaignState::finished && !queue_is_held_ && !queue_.empty() && !stop_requested_;
}

void Engine::begin_next_by_itself() {
  if (looks_into_slots_ || station_->now_s() < next_begin_s_) return;
  const auto entered = station_->enter_left_runs();
  if (entered && !*entered) return;  // beside this thread: the next turn asks again
  give_notice();
  drop_what_has_begun();
  const auto first = queue_.front();
  if (!first) return;
  const auto begun = entered ? try_to_begin(*first) : base::forward_error(entered);
  if (begun) return;
  const base::Error& error = begun.error();
  queue_is_held_ = !may_pass(error) || station_->now_s() - queue_since_s_ > kTryFor_s;
  const std::string trouble =
      fmt::format("{}: {}: {}", queue_is_held_ ? "does not begin, it waits for somebody" : "cannot begin yet",
                  error.where, error.message);
  if (trouble != queue_trouble_) log_.add("campaign", first->request.campaign, trouble);
  queue_trouble_ = trouble;
}

base::Status Engine::try_to_begin(const QueuedCampaign& first) {
  if (!journal_->wait_until_written(kEntryOfNext)) {
    return base::fail(base::ErrorKind::internal, journal_->standing().trouble, "journal");
  }
  if (auto connected = connect_devices(); !connected) {
    device_was_silent_ = true;
    return connected;
  }
  if (station_->chamber.reading()->running) {
    return base::bad_input("heating and cooling are on: somebody uses it", chamber_->description());
  }
  // Somebody may have switched it off and on again: they, too, have their time to see what will happen.
  if (std::exchange(device_was_silent_, false)) {
    queue_trouble_.clear();
    return {};
  }
  const auto begun = begin_first(first, "soakd");
  return begun ? base::Status{} : base::forward_error(begun);
}

nlohmann::json Engine::queue_document() const {
  const bool resumes =
      resumes_by_itself_ && (state_ == CampaignState::interrupted || state_ == CampaignState::stopping);
  const bool by_itself = next_begins_by_itself();
  const bool after_this = resumes || (is_under_way(state_) && !queue_is_held_);
  nlohmann::json waits_for;
  if (!queue_.empty()) waits_for = by_itself ? "time" : after_this ? "campaign" : "somebody";
  return {{"campaigns", queue_.document()},
          {"waits_for", std::move(waits_for)},
          {"begins_utc_s", by_itself ? nlohmann::json(next_begin_utc_s_) : nlohmann::json()},
          {"trouble", queue_trouble_.empty() ? nlohmann::json() : nlohmann::json(queue_trouble_)}};
}

}  // namespace soak::station
