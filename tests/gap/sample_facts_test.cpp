// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/campaign.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.h"

namespace soak::calib::gap {
namespace {

std::vector<double> noise(double step, double rail) {
  base::Random random(5);
  std::vector<double> samples;
  for (int i = 0; i < 30000; ++i) {
    double value = random.gaussian();
    if (step > 0.0) value = step * std::round(value / step);
    samples.push_back(std::clamp(value, -rail, rail));
  }
  return samples;
}

TEST(SampleFacts, OfContinuousNoiseAreNeitherStepNorRail) {
  const SampleFacts facts = sample_facts(noise(0.0, 1e9));
  EXPECT_FALSE(facts.step);
  EXPECT_EQ(facts.at_rails, 0U);
  EXPECT_NEAR(facts.noise, 1.0, 0.03);
}

TEST(SampleFacts, TellTheStepOfALattice) {
  const SampleFacts facts = sample_facts(noise(0.25, 1e9));
  ASSERT_TRUE(facts.step);
  EXPECT_NEAR(*facts.step, 0.25, 1e-12);
  EXPECT_EQ(facts.at_rails, 0U) << "the outermost steps of a lattice are no rails";
}

TEST(SampleFacts, CountSamplesThatStickAtTheEnds) {
  const auto samples = noise(0.0, 1.5);
  const auto stuck = std::count_if(samples.begin(), samples.end(), [](double x) { return std::abs(x) == 1.5; });
  const SampleFacts facts = sample_facts(samples);
  EXPECT_EQ(facts.at_rails, static_cast<std::size_t>(stuck));
  EXPECT_EQ(facts.high_rail, 1.5);
}

TEST(SampleFacts, OfAConstantAreNoRail) {
  const SampleFacts facts = sample_facts(std::vector<double>(1000, 0.5));
  EXPECT_EQ(facts.at_rails, 0U);
  EXPECT_FALSE(facts.step);
  EXPECT_EQ(facts.count, 1000U);
}

TEST(SampleFacts, OfNothingAreEmpty) { EXPECT_EQ(sample_facts({}).count, 0U); }

}  // namespace
}  // namespace soak::calib::gap
