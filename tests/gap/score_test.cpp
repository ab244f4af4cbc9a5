// SPDX-License-Identifier: Apache-2.0
// Chances of a false name: those stated are those that happen.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr int kCampaigns = 20'000;
constexpr int kRuns = 6;

/// A term of slow shape in one sensor where nothing is: each run shows one value of it, and only their scatter tells
/// how far such values go.
TermTest slow_chance(std::mt19937_64& random) {
  std::normal_distribution<double> value;
  std::vector<double> runs;
  double mean = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    runs.push_back(value(random));
    mean += runs.back() / kRuns;
  }
  double squares = 0.0;
  for (const double of_run : runs) squares += (of_run - mean) * (of_run - mean);
  TermTest test;
  test.gain = kRuns * mean * mean / (squares / (kRuns - 1));
  test.dof = 1.0;
  test.heterogeneity_dof = kRuns - 1;
  test.noise_dof = kRuns - 1;
  test.slow_share = 1.0;
  return test;
}

/// How many campaigns have a chance below `gate` in sensors that each tell their own noise.
int below(double gate, std::size_t sensors, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  int count = 0;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    std::vector<TermTest> tests;
    for (std::size_t s = 0; s < sensors; ++s) tests.push_back(slow_chance(random));
    std::vector<const TermTest*> together;
    for (const TermTest& test : tests) together.push_back(&test);
    if (p_value(together, 1.0) < gate) ++count;
  }
  return count;
}

// Bounds: four standard deviations of the count about what is stated.
TEST(ChanceOfSlowTerms, IsTheOneStatedInOneSensor) {
  EXPECT_NEAR(below(0.01, 1, 7101), 200, 57);
  EXPECT_NEAR(below(0.001, 1, 7102), 20, 18);
}

TEST(ChanceOfSlowTerms, IsTheOneStatedInSixSensorsTogether) {
  EXPECT_NEAR(below(0.01, 6, 7103), 200, 57);
  EXPECT_NEAR(below(0.001, 6, 7104), 20, 18);
}

TEST(ChanceOfQuickTerms, IsThatOfTheirSquaresTogether) {
  TermTest test;
  test.gain = 9.0;
  test.dof = 1.0;
  test.noise_dof = 24.0;
  const std::vector<const TermTest*> together = {&test, &test, &test};
  EXPECT_DOUBLE_EQ(p_value(together, 1.0), p_value(pooled(together), 1.0));
}

}  // namespace
}  // namespace soak::calib::gap
