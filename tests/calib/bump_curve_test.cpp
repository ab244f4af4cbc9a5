// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/bump_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "calib/model/unit_model.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

/// A resonance by its textbook formula: half as high a width beside its centre.
double resonance(double temp_c) { return 3e-3 / (1.0 + std::pow((temp_c - 31.0) / 2.0, 2)); }

const CurveBump kBump = {.height = 3e-3, .centre_c = 31.0, .width_c = 2.0};

ModelTerm bump_term(Sensor sensor) {
  ModelTerm term;
  term.name = "narrow_bump";
  term.parts = {{{sensor},
                 {{"height", 3e-3, "rad/s"}, {"centre_c", 31.0, "degC"}, {"width_c", 2.0, "K"}},
                 {1e-8, 0, 0, 0, 0.09, 0, 0, 0, 0.04},
                 {}}};
  return term;
}

double smooth(double temp_c) { return 2e-3 * std::tanh((temp_c - 10.0) / 30.0); }

TEST(BumpCurve, IsTheCurveAndTheResonanceWhateverTheCurveIs) {
  SplineCurve spline{{-30.0, 0.0, 70.0}, {{1e-3, 2e-5, 1e-7, 0.0}, {1.69e-3, -1e-5, 0.0, 1e-9}}};
  TableCurve table{-30.0, 10.0, {0.0, 1e-3, 3e-3, 2e-3, 5e-3, 4e-3, 1e-3, 0.0, 2e-3, 1e-3, 0.0}, {}};
  for (const Curve& curve : {Curve(spline), Curve(table), Curve(samples::fis(0, anfis::Shape::bell, 1e-3, 2e-3))}) {
    const SplineCurve sum = with_bump(curve, kBump);
    EXPECT_LE(sum.coefficients.size(), 1024U);  // what a calibration file can hold
    const auto [low_c, high_c] = domain_of(curve);
    for (int i = 0; i <= 1000; ++i) {
      const double temp_c = low_c + (high_c - low_c) * i / 1000.0;
      EXPECT_NEAR(evaluate(Curve(sum), temp_c), evaluate(curve, temp_c) + resonance(temp_c), 3e-7) << temp_c;
    }
    EXPECT_EQ(domain_of(Curve(sum)), domain_of(curve));
  }
}

TEST(BumpCurve, IsThatOfTheSensorThatTheTermNames) {
  const std::vector<ModelTerm> terms = {bump_term(Sensor::gyro_y)};
  const auto found = bump_of(terms, Sensor::gyro_y);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->height, 3e-3);
  EXPECT_EQ(found->centre_c, 31.0);
  EXPECT_EQ(found->width_c, 2.0);
  EXPECT_EQ(found->covariance(0, 0), 1e-8);
  EXPECT_EQ(found->covariance(1, 1), 0.09);
  EXPECT_FALSE(bump_of(terms, Sensor::gyro_x));
}

// Bumps drawn from what is known of one scatter as it says, as long as that is little.
TEST(BumpCurve, ItsErrorIsTheScatterOfTheBumpsThatItMayBe) {
  CurveBump bump = kBump;
  bump.covariance = Eigen::Vector3d(1e-4 * 1e-4, 0.1 * 0.1, 0.08 * 0.08).asDiagonal();
  base::Random random(5);
  for (const double temp_c : {31.0, 30.0, 33.0, 38.0}) {
    double squares = 0.0;
    constexpr int kDraws = 20000;
    for (int n = 0; n < kDraws; ++n) {
      const double height = 3e-3 + 1e-4 * random.gaussian();
      const double off = (temp_c - 31.0 - 0.1 * random.gaussian()) / (2.0 + 0.08 * random.gaussian());
      squares += std::pow(height / (1.0 + off * off) - resonance(temp_c), 2) / kDraws;
    }
    EXPECT_NEAR(bump.error_at(temp_c) / std::sqrt(squares), 1.0, 0.05) << temp_c;
  }
}

/// Three runs over plateaus 5 K apart, with the resonance in one gyro; the truth of the fit.
UnitRows rows_with_resonance(bool accepted) {
  UnitRows rows;
  CurveData data;
  data.runs = {"R1", "R2", "R3"};
  data.branches = {"run 1 up", "run 2 up", "run 3 up"};
  for (int run = 0; run < 3; ++run) {
    for (int k = 0; k <= 20; ++k) {
      const double temp_c = -30.0 + 5.0 * k + 0.1 * (run - 1);
      const double noise = 1e-5 * std::sin(17.0 * k + 5.0 * run);
      data.rows.push_back({run, run, Sweep::up, 1000.0 * k, temp_c, smooth(temp_c) + resonance(temp_c) + noise, 1e-5});
    }
  }
  rows.bias[index_of(Sensor::gyro_y)] = data;
  if (accepted) rows.terms = {bump_term(Sensor::gyro_y)};
  return rows;
}

double error_of(const SensorFit& fit) {
  double squares = 0.0;
  for (int k = 0; k <= 200; ++k) {
    const double temp_c = -29.0 + 0.49 * k;
    squares += std::pow(evaluate(fit.bias.curve, temp_c) - smooth(temp_c) - resonance(temp_c), 2) / 201.0;
  }
  return std::sqrt(squares);
}

TEST(BumpCurve, IsFittedBesideAnAcceptedBumpAndDeployedWithIt) {
  const auto before = fit_sensor(rows_with_resonance(false), Sensor::gyro_y, {});
  const auto after = fit_sensor(rows_with_resonance(true), Sensor::gyro_y, {});
  ASSERT_TRUE(before && after);
  EXPECT_LT(error_of(*after), 2e-5);
  EXPECT_LT(error_of(*after), 0.2 * error_of(*before));
  double at_bump = 0.0;
  double aside = 0.0;
  for (const CurvePoint& point : after->bias.points) {
    EXPECT_NEAR(point.value, evaluate(after->bias.curve, point.temp_c), 1e-9);
    if (std::abs(point.temp_c - 31.0) < 0.6) at_bump = std::max(at_bump, point.ci95);
    if (std::abs(point.temp_c - 0.0) < 0.6) aside = std::max(aside, point.ci95);
  }
  // The height is known to 1e-4 (k = 1), the place to 0.3 K, which no scatter of the runs shows.
  EXPECT_GT(at_bump, 1.9e-4);
  EXPECT_LT(aside, 1e-4);
}

}  // namespace
}  // namespace soak::calib
