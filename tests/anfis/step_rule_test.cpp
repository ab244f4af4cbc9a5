// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/detail/training_steps.h"

#include <gtest/gtest.h>

namespace soak::anfis::training {
namespace {

// Epochs (from 1) after which the step changed, negative for a decrease.
std::vector<int> changes(StepRule rule, const std::vector<double>& errors) {
  std::vector<int> epochs;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double before = rule.step();
    rule.record(errors[i]);
    if (rule.step() != before) {
      epochs.push_back((rule.step() > before ? 1 : -1) * static_cast<int>(i + 1));
    }
  }
  return epochs;
}

StepRule usual() { return StepRule(0.01, 0.9, 1.1); }

TEST(StepRule, RaisesAfterEpochFiveAndThenEveryFourthWhileTheErrorFalls) {
  std::vector<double> falling;
  for (int i = 0; i < 18; ++i) {
    falling.push_back(100.0 - i);
  }
  EXPECT_EQ(changes(usual(), falling), (std::vector<int>{5, 9, 13, 17}));  // the epochs of MATLAB's logs
}

TEST(StepRule, LowersAfterTwoZigzagsThatEndOnAReduction) {
  EXPECT_EQ(changes(usual(), {5, 6, 5, 6, 5}), (std::vector<int>{-5}));
  EXPECT_EQ(changes(usual(), {6, 5, 6, 5, 6}), (std::vector<int>{}));
  EXPECT_EQ(changes(usual(), {6, 5, 6, 5, 6, 5}), (std::vector<int>{-6}));
}

TEST(StepRule, WaitsFourEpochsBetweenDecreases) {
  EXPECT_EQ(changes(usual(), {5, 6, 5, 6, 5, 6, 5, 6, 5, 6, 5}), (std::vector<int>{-5, -9}));
}

TEST(StepRule, CountsTheWaitOfEachKindSeparately) {
  // increase after 5; zigzag of epochs 6..9 lowers at once though the increase is only four epochs old
  EXPECT_EQ(changes(usual(), {9, 8, 7, 6, 5, 6, 5, 6, 5}), (std::vector<int>{5, -9}));
  // decrease after 5, four reductions later an increase after 8 (epochs 5..8 reduce: 5th to 8th difference)
  EXPECT_EQ(changes(usual(), {9, 10, 9, 10, 9, 8, 7, 6}), (std::vector<int>{-5, 8}));
}

TEST(StepRule, CountsOnlyStrictChanges) {
  EXPECT_EQ(changes(usual(), {5, 4, 3, 3, 2, 1}), (std::vector<int>{}));
  EXPECT_EQ(changes(usual(), {5, 5, 5, 5, 5, 5}), (std::vector<int>{}));
}

TEST(StepRule, AFactorOfOneSwitchesItsKindOff) {
  EXPECT_EQ(changes(StepRule(0.01, 0.9, 1.0), {9, 8, 7, 6, 5, 4}), (std::vector<int>{}));
  EXPECT_EQ(changes(StepRule(0.01, 1.0, 1.1), {5, 6, 5, 6, 5}), (std::vector<int>{}));
}

TEST(StepRule, MultipliesByItsFactors) {
  StepRule rule(0.02, 0.5, 3.0);
  for (const double e : {5.0, 4.0, 3.0, 2.0, 1.0}) {
    rule.record(e);
  }
  EXPECT_DOUBLE_EQ(rule.step(), 0.06);
}

}  // namespace
}  // namespace soak::anfis::training
