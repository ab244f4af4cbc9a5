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

}  // namespace

// --- what people ask --------------------------------------------------------------------------------------------

base::Result<nlohmann::json> Engine::queue(const StartRequest& request) {
  return command_after_left_runs([this, request]() -> base::Result<nlohmann::json> {
    const bool nothing_before = queue_.waiting().empty() && can(state_, CampaignEvent::start) && !is_resumable(state_);
    if (!nothing_before) return do_queue(request);
    auto begun = do_start(request, std::nullopt);
    if (begun) (*begun)["before"] = 0;
    return begun;
  });
}

/// Checks what can be known before it begins: then nobody is here.
base::Result<nlohmann::json> Engine::do_queue(const StartRequest& request) {
  if (stop_requested_) return base::bad_input("soakd is stopping", "state");
  const auto checked = check_start(request, config_, catalog_);
  if (!checked) return base::forward_error(checked);
  const auto known = catalog_.campaign(request.campaign);
  if (!known) return base::forward_error(known);
  if (*known) {
    return base::bad_input(fmt::format("campaign '{}' exists already: choose another name", request.campaign),
                           "campaign");
  }
  double before_s = is_under_way(state_) ? estimate_after_step_s() : 0.0;
  for (const QueuedCampaign& queued : queue_.waiting()) before_s += queued.estimate_s;
  const auto judged =
      check_references(catalog_, *checked, 0, now_utc_s() + before_s / config_.clock_rate, config_.clock_rate);
  if (!judged) return base::forward_error(judged);
  const double estimate_s = checked->plan.remaining_s(0);
  const std::size_t before = queue_.waiting().size() + (is_under_way(state_) ? 1 : 0);
  if (auto added = queue_.add({request, checked->plan.procedure.name, estimate_s, now_utc_s()}); !added) {
    return base::forward_error(added);
  }
  log_.add("campaign", request.campaign, fmt::format("queued by {}, {} before it", request.user, before), request.user);
  return nlohmann::json{{"campaign", request.campaign},
                        {"runs", checked->plan.runs.size()},
                        {"steps", checked->plan.steps.size()},
                        {"estimate_s", estimate_s},
                        {"notes", judged->notes},
                        {"before", before}};
}

base::Status Engine::unqueue(const std::string& user, const std::string& campaign) {
  return status_command([=, this]() -> base::Status {
    if (auto removed = queue_.remove(campaign); !removed) return removed;
    log_.add("campaign", campaign, "taken out of the queue by " + user, user);
    return {};
  });
}

base::Status Engine::next(const std::string& user) {
  const auto begun = command_after_left_runs([this, user] { return do_next(user); });
  return begun ? base::Status{} : base::forward_error(begun);
}

base::Result<nlohmann::json> Engine::do_next(const std::string& user) {
  if (queue_.waiting().empty()) return base::bad_input("no campaign is in the queue", "state");
  StartRequest request = queue_.waiting().front().request;
  request.user = user;
  auto begun = do_start(request, std::nullopt);
  if (!begun) return begun;
  // It has begun all the same: the next soakd finds it in the catalog and takes it out of the queue.
  if (auto removed = queue_.remove(request.campaign); !removed) {
    log_.add("campaign", request.campaign, "cannot be taken out of the queue: " + removed.error().message);
  }
  return begun;
}

// --- what the station does --------------------------------------------------------------------------------------

/// What a predecessor left in the queue and has begun is no longer in it.
void Engine::restore_queue() {
  if (!queue_.trouble().empty()) log_.add("campaign", "queue", queue_.trouble());
  const std::vector<QueuedCampaign> waiting = queue_.waiting();
  for (const QueuedCampaign& queued : waiting) {
    const auto known = catalog_.campaign(queued.request.campaign);
    if (known && *known) (void)queue_.remove(queued.request.campaign);
  }
}

void Engine::begin_next_by_itself() {
  if (queue_.waiting().empty() || station_->now_s() < next_begin_s_) return;
  const auto entered = station_->enter_left_runs();
  if (entered && !*entered) return;  // beside this thread: the next turn asks again
  next_begin_s_ = station_->now_s() + kGrace_s;
  const std::string campaign = queue_.waiting().front().request.campaign;
  const auto begun = entered ? try_to_begin_next() : base::forward_error(entered);
  if (begun) return;
  const base::Error& error = begun.error();
  // A device may not answer yet, or the catalog be locked. A refusal of the plan is for people.
  queue_goes_on_ = error.kind != base::ErrorKind::bad_input;
  const std::string trouble =
      fmt::format("{}: {}: {}", queue_goes_on_ ? "cannot begin yet" : "does not begin, it waits for somebody",
                  error.where, error.message);
  if (trouble != queue_trouble_) log_.add("campaign", campaign, trouble);
  queue_trouble_ = trouble;
}

base::Status Engine::try_to_begin_next() {
  if (!journal_->wait_until_written(kEntryOfNext)) {
    return base::fail(base::ErrorKind::internal, journal_->standing().trouble, "journal");
  }
  if (auto connected = connect_devices(); !connected) return connected;
  if (station_->chamber.reading()->running) {
    return base::bad_input("heating and cooling are on: somebody uses it", chamber_->description());
  }
  const auto begun = do_next(queue_.waiting().front().request.user);
  return begun ? base::Status{} : base::forward_error(begun);
}

/// The next campaign begins by itself only after one that finished: what else ended needs somebody to look at it.
void Engine::let_queue_go_on(bool goes_on) {
  queue_goes_on_ = goes_on;
  queue_trouble_.clear();
  next_begin_s_ = station_->now_s() + kGrace_s;
  next_begin_utc_s_ = now_utc_s() + kGrace_s / config_.clock_rate;
}

bool Engine::next_begins_by_itself() const {
  return state_ == CampaignState::finished && queue_goes_on_ && !queue_.waiting().empty() && !stop_requested_;
}

nlohmann::json Engine::queue_document() const {
  const bool after_this = is_under_way(state_) || (state_ == CampaignState::interrupted && resumes_by_itself_);
  const bool by_itself = next_begins_by_itself();
  nlohmann::json waits_for;
  if (!queue_.waiting().empty()) waits_for = after_this ? "campaign" : by_itself ? "time" : "somebody";
  return {{"campaigns", queue_.document()},
          {"waits_for", std::move(waits_for)},
          {"begins_utc_s", by_itself ? nlohmann::json(next_begin_utc_s_) : nlohmann::json()},
          {"trouble", queue_trouble_.empty() ? nlohmann::json() : nlohmann::json(queue_trouble_)}};
}

}  // namespace soak::station
