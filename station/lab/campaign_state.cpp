// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_state.h"

#include <algorithm>
#include <array>

namespace soak::station {

const std::vector<CampaignTransition>& campaign_transitions() {
  using S = CampaignState;
  using E = CampaignEvent;
  static const std::vector<CampaignTransition> table = {
      {S::idle, E::start, S::running},         {S::interrupted, E::start, S::running},
      {S::finished, E::start, S::running},     {S::aborted, E::start, S::running},
      {S::failed, E::start, S::running},

      {S::running, E::suspend, S::suspended},  {S::suspended, E::go_on, S::running},
      {S::running, E::pause, S::paused},       {S::suspended, E::pause, S::paused},
      {S::paused, E::resume, S::running},      {S::running, E::finish, S::finished},

      {S::running, E::abort, S::stopping},     {S::suspended, E::abort, S::stopping},
      {S::paused, E::abort, S::stopping},      {S::stopping, E::abort, S::stopping},
      {S::running, E::fail, S::stopping},      {S::suspended, E::fail, S::stopping},
      {S::paused, E::fail, S::stopping},       {S::running, E::stop, S::stopping},
      {S::suspended, E::stop, S::stopping},    {S::paused, E::stop, S::stopping},
      {S::idle, E::restart, S::stopping},

      {S::stopping, E::safe, S::interrupted},  {S::stopping, E::safe, S::aborted},
      {S::stopping, E::safe, S::failed},

      {S::interrupted, E::resume, S::running}, {S::failed, E::resume, S::running},
      {S::interrupted, E::abort, S::aborted},
  };
  return table;
}

bool can(CampaignState state, CampaignEvent event) {
  return std::ranges::any_of(campaign_transitions(),
                             [&](const auto& row) { return row.from == state && row.event == event; });
}

bool may_follow(CampaignState from, CampaignState to) {
  return std::ranges::any_of(campaign_transitions(), [&](const auto& row) { return row.from == from && row.to == to; });
}

bool is_under_way(CampaignState state) { return can(state, CampaignEvent::fail); }

bool is_resumable(CampaignState state) { return !is_under_way(state) && can(state, CampaignEvent::resume); }

std::string_view name_of(CampaignState state) {
  constexpr std::array<std::string_view, 9> kNames = {"idle",        "running",  "waiting", "paused", "stopping",
                                                      "interrupted", "finished", "aborted", "failed"};
  return kNames.at(static_cast<std::size_t>(state));
}

std::string_view journal_name_of(CampaignState state) {
  const bool stays_open = state == CampaignState::suspended || state == CampaignState::stopping;
  return name_of(stays_open ? CampaignState::running : state);
}

}  // namespace soak::station
