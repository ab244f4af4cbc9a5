// SPDX-License-Identifier: Apache-2.0
// What the engine finds when it begins: campaigns that a predecessor did not end.
#include "station/lab/engine.h"
#include "station/lab/lost_runs.h"
#include "station/lab/start_check.h"

namespace soak::station {

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
  safe_end_ = std::make_unique<SafeEnd>(reason, lab_->procedure().end_c, false);
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

}  // namespace soak::station
