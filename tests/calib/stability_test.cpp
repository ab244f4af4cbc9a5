// SPDX-License-Identifier: Apache-2.0
#include "calib/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "base/random.h"

namespace soak::calib {
namespace {

/// The truth and what a thermometer makes of it; exponential approach by `step_c` with time constant `tau_s`.
struct Experiment {
  double step_c = 5.0;
  double tau_s = 200.0;
  double ramp_kpmin = 0.0;
  double noise_c = 0.02;
  double resolution_c = 1.0 / 256.0;
  double lag_s = 0.0;
  double interval_s = 0.5;
  double duration_s = 14400.0;
  std::uint64_t seed = 1;

  [[nodiscard]] double truth_c(double t_s) const {
    return 25.0 - step_c * std::exp(-t_s / tau_s) + ramp_kpmin * t_s / 60.0;
  }
  [[nodiscard]] double truth_kpmin(double t_s) const {
    return 60.0 * step_c / tau_s * std::exp(-t_s / tau_s) + ramp_kpmin;
  }
};

struct Declaration {
  std::optional<double> first_s;   ///< when it was first called stable
  double worst_truth_kpmin = 0.0;  ///< largest true slope while it was called stable
  bool quantised = false;          ///< ever
};

Declaration watch(const Experiment& experiment, const StabilityCriterion& criterion = {}) {
  StabilityJudge judge(criterion);
  Declaration result;
  double shown_c = experiment.truth_c(0.0);
  const auto readings = static_cast<int>(experiment.duration_s / experiment.interval_s);
  for (int i = 0; i < readings; ++i) {
    const double t_s = i * experiment.interval_s;
    const double truth = experiment.truth_c(t_s);
    shown_c += experiment.lag_s > 0.0 ? (truth - shown_c) * experiment.interval_s / experiment.lag_s : truth - shown_c;
    const double noisy =
        shown_c + experiment.noise_c * base::hashed_gaussian(experiment.seed, 7, static_cast<std::uint64_t>(i));
    judge.add(t_s, std::round(noisy / experiment.resolution_c) * experiment.resolution_c);
    if (i % 20 != 0) continue;
    const StabilityVerdict verdict = judge.verdict();
    result.quantised = result.quantised || verdict.quantised;
    if (!verdict.stable) continue;
    if (!result.first_s) result.first_s = t_s;
    result.worst_truth_kpmin = std::max(result.worst_truth_kpmin, std::abs(experiment.truth_kpmin(t_s)));
  }
  return result;
}

TEST(StabilityJudge, DeclaresAnOrdinaryThermometerStableOnlyOnceTheTruthMovesLessThanTheLimit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Declaration declared = watch({.seed = seed});
    ASSERT_TRUE(declared.first_s.has_value());
    EXPECT_LE(declared.worst_truth_kpmin, 0.02);
    // The truth itself passes 0.02 K/min after tau·ln(1.5/0.02) = 863 s; a window's length later it must be seen.
    EXPECT_LE(*declared.first_s, 863.0 + 400.0);
  }
}

TEST(StabilityJudge, IsNotDeceivedByASlowThermometer) {
  for (const double lag_s : {60.0, 300.0, 900.0}) {
    const Declaration declared = watch({.lag_s = lag_s});
    ASSERT_TRUE(declared.first_s.has_value()) << lag_s;
    EXPECT_LE(declared.worst_truth_kpmin, 0.02) << lag_s;
  }
}

TEST(StabilityJudge, IsNotDeceivedByANoisyThermometer) {
  for (const double noise_c : {0.1, 0.3, 1.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      EXPECT_LE(watch({.noise_c = noise_c, .seed = seed}).worst_truth_kpmin, 0.02) << noise_c;
    }
  }
}

TEST(StabilityJudge, NeverCallsALastingDriftAboveTheLimitStable) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Declaration declared = watch({.step_c = 0.0, .ramp_kpmin = 0.025, .noise_c = 0.05, .seed = seed});
    EXPECT_FALSE(declared.first_s.has_value()) << seed;
  }
}

TEST(StabilityJudge, AThermometerInWholeDegreesIsNeverStableByItself) {
  for (const double noise_c : {0.0, 0.02, 0.2}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Declaration declared = watch({.noise_c = noise_c, .resolution_c = 1.0, .seed = seed});
      EXPECT_FALSE(declared.first_s.has_value());
      EXPECT_TRUE(declared.quantised);
    }
  }
}

TEST(StabilityJudge, NoiseOfSeveralStepsMakesACoarseThermometerUsable) {
  const Declaration declared = watch({.noise_c = 0.1, .resolution_c = 1.0 / 16.0}, {.window_s = 900.0});
  ASSERT_TRUE(declared.first_s.has_value());
  EXPECT_LE(declared.worst_truth_kpmin, 0.02);
}

TEST(StabilityJudge, ForgetsWhatItReadBeforeADisturbance) {
  StabilityJudge judge({});
  for (int i = 0; i < 1000; ++i) judge.add(0.5 * i, 25.0 + 0.005 * (i % 3));
  ASSERT_TRUE(judge.verdict().stable);
  judge.disturb(30.0);
  EXPECT_FALSE(judge.verdict().stable);
  for (int i = 0; i < 50; ++i) judge.add(500.0 + 0.5 * i, 25.0 + 0.005 * (i % 3));
  EXPECT_FALSE(judge.verdict().slope_kpmin.has_value());
  for (int i = 50; i < 200; ++i) judge.add(500.0 + 0.5 * i, 25.0 + 0.005 * (i % 3));
  EXPECT_TRUE(judge.verdict().stable);
}

TEST(StabilityJudge, ReportsTheSlopeOfALineExactly) {
  StabilityJudge judge({});
  for (int i = 0; i <= 480; ++i) judge.add(0.5 * i, 20.0 + 0.5 / 60.0 * 0.5 * i);
  const StabilityVerdict verdict = judge.verdict();
  ASSERT_TRUE(verdict.slope_kpmin.has_value());
  EXPECT_NEAR(*verdict.slope_kpmin, 0.5, 1e-9);
  EXPECT_NEAR(*verdict.half_width_kpmin, 0.0, 1e-6);
  EXPECT_FALSE(verdict.stable);
}

}  // namespace
}  // namespace soak::calib
