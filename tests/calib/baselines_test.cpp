// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/baselines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"

namespace soak::calib {
namespace {

anfis::TrainingData sampled(double (*f)(double), double noise, std::uint64_t seed, int groups = 1) {
  anfis::TrainingData data;
  base::Random random(seed);
  for (int g = 0; g < groups; ++g) {
    for (double t = -30.0; t <= 70.0; t += 5.0) {
      data.x.push_back(t + 0.2 * random.gaussian());
      data.y.push_back(f(data.x.back()) + noise * random.gaussian());
      data.weight.push_back(noise > 0.0 ? 1.0 / (noise * noise) : 1.0);
      data.group.push_back(g);
    }
  }
  return data;
}

double cubic(double t) { return 0.3 - 2e-3 * t + 4e-5 * t * t - 5e-7 * t * t * t; }
double quintic(double t) { return cubic(t) + 1e-10 * std::pow(t - 20.0, 5); }
double bumpy(double t) { return std::sin(t / 20.0) + 0.5 * std::exp(-0.5 * std::pow((t - 40.0) / 8.0, 2)); }

TEST(Polynomial, IsExactOnPolynomialsOfItsDegree) {
  const auto three = fit_polynomial(sampled(cubic, 0.0, 1), 3);
  const auto five = fit_polynomial(sampled(quintic, 0.0, 1), 5);
  ASSERT_TRUE(three && five);
  EXPECT_EQ(std::get<SplineCurve>(three->curve).coefficients.size(), 1U);
  for (double t = -29.0; t < 69.0; t += 0.7) {
    EXPECT_NEAR(evaluate(three->curve, t), cubic(t), 1e-12);
    EXPECT_NEAR(evaluate(five->curve, t), quintic(t), 1e-6);  // 64 Hermite pieces
  }
}

TEST(Polynomial, RefusesMoreCoefficientsThanTemperatures) {
  anfis::TrainingData data;
  data.x = {0, 0.1, 10, 10.1, 20};
  data.y = {1, 1, 2, 2, 3};
  const auto fit = fit_polynomial(data, 3);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().kind, base::ErrorKind::bad_input);
}

TEST(Polynomial, StatesTheVarianceOfItsCurve) {
  // Repeated fits of noisy data scatter as the stated variance says.
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto fit = fit_polynomial(sampled(cubic, 0.01, seed), 3);
    for (const double t : {-25.0, 20.0, 65.0}) {
      squares += std::pow(evaluate(fit->curve, t) - cubic(t), 2) / fit->variance(t);
      ++count;
    }
  }
  EXPECT_NEAR(squares / count, 1.0, 0.15);
}

TEST(SmoothingSpline, InterpolatesNoiseFreeData) {
  const auto fit = fit_smoothing_spline(sampled(bumpy, 0.0, 1));
  ASSERT_TRUE(fit);
  for (double t = -25.0; t < 65.0; t += 0.7) EXPECT_NEAR(evaluate(fit->curve, t), bumpy(t), 6e-3);
}

TEST(SmoothingSpline, ReproducesAStraightLineWhateverTheNoiseLevelAsksFor) {
  const auto fit = fit_smoothing_spline(sampled([](double t) { return 2.0 + 0.1 * t; }, 0.0, 3));
  for (double t = -29.0; t < 69.0; t += 1.3) EXPECT_NEAR(evaluate(fit->curve, t), 2.0 + 0.1 * t, 1e-7);
}

TEST(SmoothingSpline, IsTwiceContinuouslyDifferentiable) {
  const auto fit = fit_smoothing_spline(sampled(bumpy, 0.02, 5, 4));
  const auto& spline = std::get<SplineCurve>(fit->curve);
  for (std::size_t k = 0; k + 1 < spline.coefficients.size(); ++k) {
    const double h = spline.knots_c[k + 1] - spline.knots_c[k];
    const auto& a = spline.coefficients[k];
    const auto& b = spline.coefficients[k + 1];
    EXPECT_NEAR(a[0] + h * (a[1] + h * (a[2] + h * a[3])), b[0], 1e-9);
    EXPECT_NEAR(a[1] + h * (2 * a[2] + 3 * h * a[3]), b[1], 1e-9);
    EXPECT_NEAR(2 * a[2] + 6 * h * a[3], 2 * b[2], 1e-9);
  }
}

/// Two runs at 25 and 35 °C only, four at 10, 20, 30 and 40 °C, each with an offset of its own: how high the one stand
/// above the others, nothing says but that the curve is smooth.
anfis::TrainingData interleaved_runs(double (*f)(double), double noise, std::uint64_t seed) {
  anfis::TrainingData data;
  base::Random random(seed);
  for (int run = 0; run < 6; ++run) {
    const double offset = 100.0 * noise * random.gaussian();
    const std::vector<double> plateaus =
        run < 2 ? std::vector<double>{25, 35} : std::vector<double>{10, 20, 30, 40, 30};
    for (const double plateau : plateaus) {
      data.x.push_back(plateau + 0.005 * random.gaussian());
      data.y.push_back(f(data.x.back()) + offset + noise * random.gaussian());
      data.weight.push_back(1.0 / (noise * noise));
      data.group.push_back(run);
    }
  }
  data.group_variance = std::numeric_limits<double>::infinity();
  return data;
}

TEST(SmoothingSpline, IsSmoothWhereOnlyRunsOfFreeOffsetHaveBeen) {
  const auto straight = [](double t) { return 0.042 - 7e-3 * t; };
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    for (const double noise : {1e-6, 1e-5, 1e-4, 1e-3}) {
      const auto fit = fit_smoothing_spline(interleaved_runs(straight, noise, seed));
      ASSERT_TRUE(fit);
      const auto off = [&](double t) { return evaluate(fit->curve, t) - straight(t); };
      EXPECT_LT(std::abs(off(25) + off(35) - off(20) - off(30)), 30.0 * noise) << "seed " << seed << " noise " << noise;
      EXPECT_LT(fit->parameters, 5.5);  // six temperatures, of which the level of two is not seen
    }
  }
}

TEST(SmoothingSpline, IsFlatWhereEachRunOfFreeOffsetHasSeenOneTemperature) {
  anfis::TrainingData data;
  data.x = {0, 10, 20, 30};
  data.y = {1.0, 3.0, -2.0, 5.0};
  data.weight = {1e4, 1e4, 1e4, 1e4};
  data.group = {0, 1, 2, 3};
  data.group_variance = std::numeric_limits<double>::infinity();
  const auto fit = fit_smoothing_spline(data);
  ASSERT_TRUE(fit);
  for (const double t : {0.0, 12.0, 30.0}) EXPECT_NEAR(evaluate(fit->curve, t), 0.0, 1e-6);
}

TEST(SmoothingSpline, BandCoversTheTruthOnAverage) {
  int inside = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto fit = fit_smoothing_spline(sampled(bumpy, 0.05, seed, 4));
    for (double t = -28.0; t < 68.0; t += 2.0) {
      inside += std::abs(evaluate(fit->curve, t) - bumpy(t)) < 1.96 * std::sqrt(fit->variance(t)) ? 1 : 0;
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(inside) / count, 0.95, 0.04);
}

TEST(TemperatureClusters, TakesNeighboursTogetherAndThinsWhatIsTooMany) {
  const auto clusters = temperature_clusters({10.0, 0.0, 0.2, 10.3, 20.0}, 0.5, 40);
  ASSERT_EQ(clusters.size(), 3U);
  EXPECT_NEAR(clusters[0], 0.1, 1e-12);
  std::vector<double> many;
  for (int i = 0; i < 500; ++i) many.push_back(i);
  const auto thinned = temperature_clusters(many, 0.5, 40);
  EXPECT_EQ(thinned.size(), 40U);
  EXPECT_EQ(thinned.front(), 0.0);
  EXPECT_EQ(thinned.back(), 499.0);
}

}  // namespace
}  // namespace soak::calib
