// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_state.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <utility>

namespace soak::station {
namespace {

using S = CampaignState;
using E = CampaignEvent;

constexpr std::array<S, 9> kAll = {S::idle,        S::running,  S::suspended, S::paused, S::stopping,
                                   S::interrupted, S::finished, S::aborted,   S::failed};

bool holds_a_set_point(S state) { return state == S::running || state == S::suspended || state == S::paused; }

TEST(CampaignStates, LeadNowhereButToTheSafeStateFromAChamberThatHoldsASetPoint) {
  for (const S from : kAll) {
    if (!holds_a_set_point(from)) continue;
    for (const S to : kAll) {
      if (!may_follow(from, to) || holds_a_set_point(to)) continue;
      // The last step of a plan has switched the chamber off.
      EXPECT_TRUE(to == S::stopping || (from == S::running && to == S::finished)) << name_of(from) << name_of(to);
    }
  }
}

TEST(CampaignStates, AreLeftOnTheWayToTheSafeStateOnlyOnceItIsReached) {
  std::set<S> next;
  for (const CampaignTransition& row : campaign_transitions()) {
    if (row.from != S::stopping || row.to == S::stopping) continue;
    EXPECT_EQ(row.event, E::safe);
    next.insert(row.to);
  }
  EXPECT_EQ(next, (std::set<S>{S::interrupted, S::aborted, S::failed}));
}

TEST(CampaignStates, CanFailBeStoppedAndBeAbortedWhereverAChamberHoldsASetPoint) {
  for (const S state : kAll) {
    EXPECT_EQ(can(state, E::fail), holds_a_set_point(state)) << name_of(state);
    EXPECT_EQ(can(state, E::stop), holds_a_set_point(state)) << name_of(state);
    EXPECT_EQ(is_under_way(state), holds_a_set_point(state)) << name_of(state);
    if (holds_a_set_point(state)) {
      EXPECT_TRUE(can(state, E::abort)) << name_of(state);
    }
  }
}

TEST(CampaignStates, BeginACampaignOnlyWhereNoneIsUnderWay) {
  for (const S state : kAll) {
    EXPECT_EQ(can(state, E::start), !holds_a_set_point(state) && state != S::stopping) << name_of(state);
  }
}

TEST(CampaignStates, GoOnByThemselvesOnlyWhereTheySuspendedThemselves) {
  for (const S state : kAll) EXPECT_EQ(can(state, E::go_on), state == S::suspended) << name_of(state);
  EXPECT_FALSE(can(S::paused, E::suspend)) << "what the operator holds only the operator lets go";
}

TEST(CampaignStates, CanBeTakenUpAgainWhereACampaignWasCutShort) {
  for (const S state : kAll) {
    EXPECT_EQ(is_resumable(state), state == S::interrupted || state == S::failed) << name_of(state);
  }
}

TEST(CampaignStates, HaveOneEndForEachEventButTheSafeState) {
  std::set<std::pair<S, E>> seen;
  for (const CampaignTransition& row : campaign_transitions()) {
    if (row.event == E::safe) continue;
    EXPECT_TRUE(seen.emplace(row.from, row.event).second) << name_of(row.from) << " " << static_cast<int>(row.event);
  }
}

TEST(CampaignStates, StayOpenInTheJournalUntilTheSafeStateIsReached) {
  // "running" and "paused" are what the catalog takes for an open campaign (db/catalog/catalog.h).
  for (const S state : kAll) {
    const bool open = journal_name_of(state) == "running" || journal_name_of(state) == "paused";
    EXPECT_EQ(open, holds_a_set_point(state) || state == S::stopping) << name_of(state);
  }
}

}  // namespace
}  // namespace soak::station
