// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/baselines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
