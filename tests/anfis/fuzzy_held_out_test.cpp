// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "anfis/select/detail/compaction.h"
#include "fuzzy_support.h"

namespace soak::anfis {
namespace {

using test::one_bent_input;

TEST(HeldOut, WholeGroupsAreHeldOut) {
  TrainingData data = one_bent_input(1, 100);
  for (int k = 0; k < 100; ++k) data.group.push_back(k % 10);
  const fuzzy::Split split = fuzzy::split(data, 0.3, 4);
  const std::set<int> fit(split.fit.group.begin(), split.fit.group.end());
  const std::set<int> held_out(split.held_out.group.begin(), split.held_out.group.end());
  EXPECT_EQ(fit.size(), 7U);
  EXPECT_EQ(held_out.size(), 3U);
  for (const int group : held_out) EXPECT_FALSE(fit.contains(group));
  EXPECT_EQ(split.fit.rows() + split.held_out.rows(), 100U);
}

TEST(HeldOut, AShareOfTheRowsWhereThereAreNoGroups) {
  const TrainingData data = one_bent_input(1, 100);
  EXPECT_EQ(fuzzy::split(data, 0.25, 4).held_out.rows(), 25U);
  EXPECT_EQ(fuzzy::split(data, 0.25, 4).held_out.y, fuzzy::split(data, 0.25, 4).held_out.y);
  EXPECT_NE(fuzzy::split(data, 0.25, 4).held_out.y, fuzzy::split(data, 0.25, 5).held_out.y);
  EXPECT_EQ(fuzzy::split(one_bent_input(1, 2), 0.01, 4).held_out.rows(), 1U);
}

TEST(HeldOut, TakesTheSimplestWithinOneErrorOfThePairedDifference) {
  const Eigen::Vector4d best(1.0, 2.0, 3.0, 4.0);
  // Differences 0.5, -0.3, 0.4, -0.1: sum 0.5, mean 0.125, squares 0.4475, error sqrt(4 * 0.4475 / 3) = 0.772.
  const Eigen::Vector4d as_good = best + Eigen::Vector4d(0.5, -0.3, 0.4, -0.1);
  // Differences 0.11, 0.09, 0.1, 0.1: sum 0.4, error far below.
  const Eigen::Vector4d worse = best + Eigen::Vector4d(0.11, 0.09, 0.1, 0.1);
  EXPECT_NEAR(fuzzy::excess(as_good, best).sum, 0.5, 1e-14);
  EXPECT_NEAR(fuzzy::excess(as_good, best).standard_error, std::sqrt(4.0 * 0.4475 / 3.0), 1e-14);
  EXPECT_EQ(fuzzy::simplest_as_good({worse, as_good, best}), 1U);
  EXPECT_EQ(fuzzy::simplest_as_good({as_good, worse, best}), 0U);
  EXPECT_EQ(fuzzy::simplest_as_good({worse, best, as_good}), 1U);
  EXPECT_EQ(fuzzy::simplest_as_good({best, best}), 0U);
}

}  // namespace
}  // namespace soak::anfis
