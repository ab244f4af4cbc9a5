// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/stability.h"

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

/// What a whole-degree thermometer without noise shows; every reading is looked at.
struct WholeDegrees {
  double start_c = 0.0;
  double end_c = 0.0;
  double tau_s = 200.0;

  [[nodiscard]] double truth_c(double t_s) const { return end_c + (start_c - end_c) * std::exp(-t_s / tau_s); }
  [[nodiscard]] double truth_kpmin(double t_s) const {
    return 60.0 * std::abs(start_c - end_c) / tau_s * std::exp(-t_s / tau_s);
  }
};

constexpr double kCoarseInterval_s = 5.0;

/// When `standing` was first said; the thermometer flickers between the two nearest degrees where it is told to.
std::optional<double> first_standing_s(const WholeDegrees& thermometer, const StabilityCriterion& criterion,
                                       double flicker_c = 0.0) {
  StabilityJudge judge(criterion);
  for (int i = 0; i < 20'000; ++i) {
    const double t_s = kCoarseInterval_s * i;
    judge.add(t_s, std::round(thermometer.truth_c(t_s) + (i % 2 == 0 ? flicker_c : -flicker_c)));
    const StabilityVerdict verdict = judge.verdict();
    EXPECT_FALSE(verdict.stable) << "never by itself";
    if (verdict.standing) return t_s;
  }
  return std::nullopt;
}

TEST(StabilityStanding, AWholeDegreeThermometerStandsOnlyOnceTheTruthMovesLessThanTheLimit) {
  double steepest_kpmin = 0.0;
  for (const std::optional<double> step_c : {std::optional<double>{1.0}, std::optional<double>{}}) {
    for (const double tau_s : {200.0, 600.0, 1200.0, 3000.0}) {
      for (const double amplitude_c : {-40.0, -1.4, 0.8, 5.0, 100.0}) {
        for (const double phase_c : {0.0, 0.2, 0.45, 0.7, 0.95}) {
          const WholeDegrees thermometer{25.0 + phase_c - amplitude_c, 25.0 + phase_c, tau_s};
          const auto first_s = first_standing_s(thermometer, {.step_c = step_c});
          ASSERT_TRUE(first_s) << tau_s << " " << amplitude_c << " " << phase_c;
          const double slope_kpmin = thermometer.truth_kpmin(*first_s);
          EXPECT_LE(slope_kpmin, 0.02) << tau_s << " " << amplitude_c << " " << phase_c;
          steepest_kpmin = std::max(steepest_kpmin, slope_kpmin);
        }
      }
    }
  }
  EXPECT_GE(steepest_kpmin, 0.005) << "slow approaches come near the limit, or this shows nothing";
}

TEST(StabilityStanding, ALastingDriftAboveTheLimitNeverStands) {
  for (const bool down : {false, true}) {
    StabilityJudge judge({.step_c = 1.0});
    for (int i = 0; i < 8000; ++i) {
      const double moved_c = 0.0205 / 60.0 * kCoarseInterval_s * i;
      judge.add(kCoarseInterval_s * i, std::round(down ? -moved_c : moved_c));
      ASSERT_FALSE(judge.verdict().standing) << i;
    }
  }
}

TEST(StabilityStanding, FlickerBetweenTwoNeighboursTakesTwiceAsLong) {
  // At 0.02 K/min one step of 1 K takes 3000 s.
  const StabilityCriterion criterion{.step_c = 1.0};
  const WholeDegrees still{25.0, 25.0, 200.0};
  const WholeDegrees between{25.5, 25.5, 200.0};
  EXPECT_EQ(first_standing_s(still, criterion), 3000.0);
  EXPECT_EQ(first_standing_s(between, criterion, 0.1), 6000.0);
  EXPECT_FALSE(first_standing_s(between, {}, 0.1)) << "of a step that is not known nothing can be said";
}

TEST(StabilityStanding, FlickerOverThreeDegreesNeverStands) {
  StabilityJudge judge({.step_c = 1.0});
  for (int i = 0; i < 4000; ++i) {
    judge.add(kCoarseInterval_s * i, 25.0 + i % 3);
    ASSERT_FALSE(judge.verdict().standing);
  }
}

/// Has stood at 25 °C for `seconds`, with readings each `kCoarseInterval_s` from `from_s` on.
void stand(StabilityJudge& judge, double from_s, double seconds) {
  for (double t_s = 0.0; t_s <= seconds; t_s += kCoarseInterval_s) judge.add(from_s + t_s, 25.0);
}

TEST(StabilityStanding, ATurnDoesNotEndItAndAnyOtherDisturbanceDoes) {
  StabilityJudge judge({.step_c = 1.0});
  stand(judge, 0.0, 4000.0);
  ASSERT_TRUE(judge.verdict().standing);
  judge.disturb(60.0);
  EXPECT_FALSE(judge.verdict().standing) << "nothing has been read since the turn";
  stand(judge, 4005.0, 120.0);
  EXPECT_TRUE(judge.verdict().standing);
  judge.disturb();
  stand(judge, 4130.0, 2990.0);
  EXPECT_FALSE(judge.verdict().standing);
  stand(judge, 4130.0 + 2995.0, 10.0);
  EXPECT_TRUE(judge.verdict().standing);
}

TEST(StabilityStanding, AFineThermometerIsStableLongBeforeItWouldStand) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    StabilityJudge judge({.step_c = 1.0 / 256.0});
    std::optional<double> stable_s;
    for (int i = 0; i < 6000 && !stable_s; ++i) {
      const double noise_c = 0.02 * base::hashed_gaussian(seed, 9, static_cast<std::uint64_t>(i));
      judge.add(0.5 * i, std::round((25.0 + noise_c) * 256.0) / 256.0);
      const StabilityVerdict verdict = judge.verdict();
      EXPECT_FALSE(verdict.standing);
      EXPECT_FALSE(verdict.quantised && verdict.slope_kpmin);
      if (verdict.stable) stable_s = 0.5 * i;
    }
    ASSERT_TRUE(stable_s);
    EXPECT_LE(*stable_s, 300.0 + 60.0);
  }
}

}  // namespace
}  // namespace soak::calib
