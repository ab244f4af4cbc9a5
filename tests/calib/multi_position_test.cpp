// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/multi_position.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

/// Truth in counts and counts per m/s², of the size of the Xsens MTi's.
using Nine = std::array<double, kTriadParameterCount>;
constexpr Nine kTruth = {33120.0, 33275.0, 32360.0, 415.0, 412.0, 414.5, 0.0034, -0.0093, 0.0214};

/// raw = diag(k)·M·f + b, written out.
Vector3 reading(const Nine& p, const Vector3& f) {
  return {p[0] + p[3] * (f[0] + p[6] * f[1] + p[7] * f[2]), p[1] + p[4] * (f[1] + p[8] * f[2]), p[2] + p[5] * f[2]};
}

Vector3 times(double factor, const Vector3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

/// Directions spread evenly over the sphere (Fibonacci's spiral).
std::vector<Vector3> spread_directions(std::size_t count) {
  std::vector<Vector3> directions;
  for (std::size_t n = 0; n < count; ++n) {
    const double z = 1.0 - (2.0 * static_cast<double>(n) + 1.0) / static_cast<double>(count);
    const double angle = static_cast<double>(n) * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    directions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return directions;
}

std::vector<Vector3> faces() { return {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}; }

/// Attitudes with noise of `stated` counts where it is so stated; `more` adds scatter of |f| that is not.
std::vector<AttitudeMean> attitudes_of(const std::vector<Vector3>& up, double stated, double more = 0.0,
                                       std::uint64_t seed = 1) {
  base::Random random(seed);
  std::vector<AttitudeMean> attitudes;
  for (const Vector3& direction : up) {
    AttitudeMean attitude;
    attitude.mean = reading(kTruth, times(base::kStandardGravity_mps2 + more * random.gaussian(), direction));
    for (std::size_t i = 0; i < 3; ++i) {
      // Every attitude and axis its own standard error: weights matter.
      attitude.standard_error[i] = stated * random.uniform(0.5, 2.0);
      attitude.mean[i] += attitude.standard_error[i] * random.gaussian();
    }
    attitudes.push_back(attitude);
  }
  return attitudes;
}

TEST(MultiPosition, RecoversNoiseFreeTruth) {
  const auto fit = calibrate_triad(attitudes_of(spread_directions(20), 0.0), base::kStandardGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  // Rounding of 33,000 counts is 4e-12; the attitudes magnify it by the condition.
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(fit->value[i] / kTruth[i], 1.0, 1e-9) << kTriadParameterNames[i];
  EXPECT_LT(fit->residual_rms_mps2, 1e-10);
  EXPECT_EQ(fit->degrees_of_freedom, 11U);
  std::printf("20 evenly spread attitudes: condition %.1f\n", fit->condition);
  EXPECT_LT(fit->condition, 10.0);
}

TEST(MultiPosition, GivesBackTheSpecificForce) {
  const auto fit = calibrate_triad(attitudes_of(spread_directions(15), 0.0), base::kStandardGravity_mps2);
  ASSERT_TRUE(fit);
  const Vector3 f = {3.0, -5.0, 7.0};
  const Vector3 back = fit->specific_force(reading(kTruth, f));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back[i], f[i], 1e-8);
}

/// Shares of 400 simulated calibrations whose 95 % intervals hold the truth, per parameter.
Nine coverage(double stated, double more, bool state_errors) {
  constexpr int kSeeds = 400;
  Nine inside{};
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    auto attitudes = attitudes_of(spread_directions(24), stated, more, seed);
    if (!state_errors) {
      for (AttitudeMean& attitude : attitudes) attitude.standard_error = {};
    }
    const auto fit = calibrate_triad(attitudes, base::kStandardGravity_mps2);
    if (!fit) continue;
    for (std::size_t i = 0; i < 9; ++i) inside[i] += std::abs(fit->value[i] - kTruth[i]) <= fit->ci95[i] ? 1.0 : 0.0;
  }
  for (double& share : inside) share /= kSeeds;
  return inside;
}

// 400 draws: the share itself has a standard deviation of 1.1 %.
void expect_95_percent(const Nine& inside, const char* what) {
  double all = 0.0;
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(inside[i], 0.95, 0.03 + 1e-9) << what << ' ' << kTriadParameterNames[i];
    all += inside[i] / 9.0;
  }
  std::printf("%s: 95 %% intervals hold the truth in %.1f %% of 400 x 9\n", what, 100.0 * all);
}

TEST(MultiPosition, IntervalsHoldTheTruthWhereNoiseIsAsStated) {
  expect_95_percent(coverage(0.5, 0.0, true), "noise as stated");
}

TEST(MultiPosition, IntervalsHoldTheTruthWhereScatterExceedsTheStandardErrors) {
  expect_95_percent(coverage(0.1, 0.003, true), "scatter beyond the standard errors");
}

TEST(MultiPosition, IntervalsHoldTheTruthWhereStandardErrorsAreNotKnown) {
  expect_95_percent(coverage(0.0, 0.003, false), "standard errors not known");
}

// The hardest: further scatter as large as noise, that χ² of 15 freedoms often misses.
TEST(MultiPosition, IntervalsNearlyHoldTheTruthWhereScatterHidesInTheNoise) {
  double all = 0.0;
  for (const double share : coverage(0.5, 0.001, true)) all += share / 9.0;
  std::printf("scatter hidden in the noise: 95 %% intervals hold the truth in %.1f %% of 400 x 9\n", 100.0 * all);
  EXPECT_NEAR(all, 0.95, 0.03);
}

TEST(MultiPosition, LackOfFitIsTheScatterThatStandardErrorsDoNotExplain) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto fit =
        calibrate_triad(attitudes_of(spread_directions(60), 0.2, 0.003, seed), base::kStandardGravity_mps2);
    ASSERT_TRUE(fit);
    squares += fit->lack_of_fit_mps2 * fit->lack_of_fit_mps2 / 40.0;
  }
  // 40 x 51 freedoms: the root of the mean square is known to 1.6 %; three of those.
  EXPECT_NEAR(std::sqrt(squares), 0.003, 0.05 * 0.003);
}

TEST(MultiPosition, SixFacesShowBiasAndScaleButNoMisalignment) {
  const auto fit = calibrate_triad(attitudes_of(faces(), 0.3), base::kStandardGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(fit->observable[i], i < 6) << kTriadParameterNames[i];
  for (std::size_t i = 6; i < 9; ++i) EXPECT_EQ(fit->value[i], 0.0);
  EXPECT_EQ(fit->degrees_of_freedom, 0U);
  for (std::size_t i = 0; i < 3; ++i) {
    // Ignored misalignments of 0.02 change |raw − b|/k by 0.02²/2; noise is 0.3 counts and more.
    EXPECT_NEAR(fit->value[i], kTruth[i], 4.0 * fit->standard_error[i] + 1.0);
    EXPECT_NEAR(fit->value[3 + i] / kTruth[3 + i], 1.0, 5e-4);
  }
  // (up + down)/2 and (up − down)/(2 g): standard errors as those of single readings by √2 and √2 g.
  EXPECT_NEAR(fit->standard_error[0], 0.3 / std::numbers::sqrt2, 0.3);
}

TEST(MultiPosition, FacesTwentyTimesOverShowNoMoreThanOnce) {
  std::vector<Vector3> many;
  for (int n = 0; n < 20; ++n) {
    for (const Vector3& face : faces()) many.push_back(face);
  }
  const auto fit = calibrate_triad(attitudes_of(many, 0.3), base::kStandardGravity_mps2);
  ASSERT_TRUE(fit);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(fit->observable[i], i < 6);
  EXPECT_EQ(fit->degrees_of_freedom, 114U);
}

TEST(MultiPosition, TiltsInOnePlaneShowTheMisalignmentOfThatPlaneAlone) {
  std::vector<Vector3> up = faces();
  for (const double sign : {1.0, -1.0}) {
    for (const double other : {1.0, -1.0}) up.push_back({0.0, sign * std::sqrt(0.5), other * std::sqrt(0.5)});
  }
  const auto fit = calibrate_triad(attitudes_of(up, 0.3), base::kStandardGravity_mps2);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_FALSE(fit->observable[index_of(TriadParameter::misalignment_xy)]);
  EXPECT_FALSE(fit->observable[index_of(TriadParameter::misalignment_xz)]);
  ASSERT_TRUE(fit->observable[index_of(TriadParameter::misalignment_yz)]);
  EXPECT_NEAR((*fit)[TriadParameter::misalignment_yz], 0.0214, 4.0 * fit->standard_error[8]);
}

TEST(MultiPosition, RefusesTooFewAttitudes) {
  const auto five = calibrate_triad(attitudes_of(spread_directions(5), 0.3), base::kStandardGravity_mps2);
  ASSERT_FALSE(five);
  EXPECT_EQ(five.error().kind, base::ErrorKind::bad_input);
  const auto eight = calibrate_triad(attitudes_of(spread_directions(8), 0.3), base::kStandardGravity_mps2);
  ASSERT_FALSE(eight);
  EXPECT_EQ(eight.error().kind, base::ErrorKind::bad_input);
}

TEST(MultiPosition, NamesTheAxisThatGravityNeverReached) {
  // Turned about the z axis only, which stays horizontal.
  std::vector<Vector3> up;
  for (int n = 0; n < 12; ++n) up.push_back({std::cos(n * 0.5236), std::sin(n * 0.5236), 0.0});
  const auto fit = calibrate_triad(attitudes_of(up, 0.3), base::kStandardGravity_mps2);
  EXPECT_TRUE(is_bad_input(fit, {"bias_z", "scale_z"}));
  EXPECT_FALSE(names(fit.error(), {"bias_x"})) << "gravity has reached x";
}

TEST(MultiPosition, RefusesAnErrorThatNothingWouldSupport) {
  const auto fit = calibrate_triad(attitudes_of(spread_directions(9), 0.0), base::kStandardGravity_mps2);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().kind, base::ErrorKind::bad_input);
  EXPECT_TRUE(calibrate_triad(attitudes_of(spread_directions(9), 0.3), base::kStandardGravity_mps2));
}

TEST(MultiPosition, RefusesReadingsThatAreNoTriadAtRest) {
  base::Random random(3);
  std::vector<AttitudeMean> attitudes(20);
  for (AttitudeMean& attitude : attitudes) {
    for (double& x : attitude.mean) x = random.gaussian();
  }
  const auto fit = calibrate_triad(attitudes, base::kStandardGravity_mps2);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().kind, base::ErrorKind::bad_input);
}

TEST(MultiPosition, RefusesNumbersThatAreNone) {
  auto attitudes = attitudes_of(spread_directions(12), 0.3);
  EXPECT_FALSE(calibrate_triad(attitudes, 0.0));
  EXPECT_FALSE(calibrate_triad(attitudes, std::nan("")));
  attitudes[3].standard_error[1] = -1.0;
  const auto negative = calibrate_triad(attitudes, base::kStandardGravity_mps2);
  ASSERT_FALSE(negative);
  EXPECT_EQ(negative.error().where, "attitude 4");
  attitudes[3].standard_error[1] = 0.1;
  attitudes[7].mean[0] = std::nan("");
  EXPECT_FALSE(calibrate_triad(attitudes, base::kStandardGravity_mps2));
}

TEST(MultiPosition, RefusesReadingsThatNeverChange) {
  std::vector<AttitudeMean> same(12, {{1.0, 2.0, 3.0}, {0.1, 0.1, 0.1}});
  EXPECT_FALSE(calibrate_triad(same, base::kStandardGravity_mps2));
  for (std::size_t n = 0; n < same.size(); ++n) same[n].mean[0] += 1e-15 * static_cast<double>(n);
  EXPECT_FALSE(calibrate_triad(same, base::kStandardGravity_mps2));
}

}  // namespace
}  // namespace soak::calib
