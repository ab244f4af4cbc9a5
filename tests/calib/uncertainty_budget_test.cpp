// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/uncertainty_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.h"
#include "calib/estimate/site.h"
#include "calib/model/unit_model.h"
#include "tests/calib/campaign_simulation.h"

namespace soak::calib {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

TEST(UncertaintyBudget, ExpandsByStudentsTAtEffectiveDegreesOfFreedom) {
  // JCGM 100:2008, H.1 (end gauge): u_c = 32 nm, ν_eff = 16; there the 99 % t factor is 2.92, of 95 % it is 2.12.
  const std::vector<Contribution> budget = {{.name = "standard", .degrees_of_freedom = 18.0, .u = {25.0}},
                                            {.name = "repeated", .degrees_of_freedom = 24.0, .u = {5.8}},
                                            {.name = "random", .degrees_of_freedom = 5.0, .u = {3.9}},
                                            {.name = "systematic", .degrees_of_freedom = 8.0, .u = {6.7}},
                                            {.name = "expansion", .degrees_of_freedom = 50.0, .u = {2.9}},
                                            {.name = "temperature", .degrees_of_freedom = 2.0, .u = {16.6}}};
  EXPECT_NEAR(expanded_uncertainty(budget, Band::mean, 0), 2.12 * 32.0, 1.0);
}

TEST(UncertaintyBudget, ContributionsWithoutNumberAndOfOtherBandsDoNotCount) {
  const std::vector<Contribution> budget = {{.name = "noise", .u = {3.0}, .u_fresh = {3.0}},
                                            {.name = "run_to_run", .u_fresh = {4.0}},
                                            {.name = "fixture", .type = 'B'}};
  EXPECT_NEAR(expanded_uncertainty(budget, Band::mean, 0), 1.95996 * 3.0, 1e-4);
  EXPECT_NEAR(expanded_uncertainty(budget, Band::fresh_power_on, 0), 1.95996 * 5.0, 1e-4);
  EXPECT_FALSE(budget[2].stated());
}

TEST(Gravity, IsAsUncertainAsItsSource) {
  EXPECT_FALSE(gravity_at({.gravity_mps2 = 9.81}).standard_uncertainty_mps2);
  const double known = *gravity_at({.latitude_deg = 51.0, .height_m = 1000.0}).standard_uncertainty_mps2;
  const double height_unknown = *gravity_at({.latitude_deg = 51.0}).standard_uncertainty_mps2;
  const double assumed = *gravity_at({}).standard_uncertainty_mps2;
  EXPECT_LT(known, height_unknown);
  EXPECT_LT(height_unknown, assumed);
  // 1000 m are 3.086 mm/s².
  EXPECT_NEAR(height_unknown, 3.086e-3 / std::sqrt(3.0), 1e-4);
  // At the pole and at the equator the standard value is off by less than two standard uncertainties.
  EXPECT_LT(std::abs(gravity_at({.latitude_deg = 90.0}).mps2 - 9.80665), 2.0 * assumed);
  EXPECT_LT(std::abs(gravity_at({.latitude_deg = 0.0}).mps2 - 9.80665), 2.0 * assumed);
}

Circumstances circumstances() {
  Circumstances of;
  of.gravity = {9.81, false, 3e-4, "stated"};
  of.latitude_deg = 51.0;
  of.thermometer_repeatability_c = 0.1;
  ReferenceUse squareness;
  squareness.reference.kind = ReferenceKind::fixture_squareness;
  squareness.reference.standard_uncertainty = 0.1 * kRad;
  of.references = {squareness};
  return of;
}

const TypeBInput& named(const std::vector<TypeBInput>& inputs, const std::string& name) {
  for (const TypeBInput& input : inputs) {
    if (input.name == name) return input;
  }
  throw std::runtime_error(name + " is missing");
}

TEST(TypeB, GravityGoesIntoTheScaleOfAccelerometersAlone) {
  const Circumstances of = circumstances();
  EXPECT_NEAR(named(scale_inputs(of, Sensor::accel_x), "gravity").constant, 1e6 * 3e-4 / 9.81, 1e-6);
  EXPECT_EQ(named(bias_inputs(of, Sensor::accel_x, true, 0.0), "gravity").constant, 0.0);
  EXPECT_EQ(named(bias_inputs(of, Sensor::accel_x, false, 0.0), "gravity").constant, 3e-4);
  EXPECT_EQ(named(bias_inputs(of, Sensor::gyro_x, false, 0.0), "gravity").constant, 0.0);
}

TEST(TypeB, WhatNobodyStatedIsNotStatedAndSaysWhatIsMissing) {
  Circumstances of;
  of.gravity = gravity_at({.gravity_mps2 = 9.81});
  for (const TypeBInput& input : scale_inputs(of, Sensor::accel_y)) {
    EXPECT_FALSE(input.stated) << input.name;
    EXPECT_EQ(input.basis.substr(0, 10), "not stated") << input.name;
  }
}

TEST(TypeB, AnOutputStepIsARectangularDistribution) {
  Circumstances of = circumstances();
  of.thermometer_repeatability_c.reset();
  of.thermometer_lsb_c = 1.0;
  EXPECT_NEAR(named(bias_inputs(of, Sensor::gyro_z, true, 0.0), "thermometer").temperature_c, 0.288675, 1e-6);
}

/// Tilts of the faces drawn at random; second implementation of what they do to (up + down)/2 and (up − down)/2.
TEST(TypeB, TiltsOfTheFacesAreAsLargeAsDrawnOnes) {
  const Circumstances of = circumstances();
  const double u = 0.1 * kRad;
  const double g = 9.81;
  base::Random random(1);
  double bias = 0.0;
  double scale = 0.0;
  double gyro = 0.0;
  constexpr int kDraws = 20000;
  const double cross = 0.02 * kRad / g;
  for (int i = 0; i < kDraws; ++i) {
    const auto cosine = [&] { return std::cos(std::hypot(u * random.gaussian(), u * random.gaussian())); };
    const double up = cosine();
    const double down = cosine();
    bias += std::pow(g * (up - down) / 2.0, 2) / kDraws;
    scale += std::pow(1e6 * ((up + down) / 2.0 - 1.0), 2) / kDraws;
    const double earth = 7.292115e-5 * std::cos(51.0 * kRad);
    const auto leak = [&] { return earth * u * random.gaussian() + g * cross * u * random.gaussian(); };
    gyro += std::pow((leak() + leak()) / 2.0, 2) / kDraws;
  }
  // Root mean squares of 20000 draws; squares of tilts are exponentially distributed: 2 % is three standard errors.
  EXPECT_NEAR(std::sqrt(bias) / named(bias_inputs(of, Sensor::accel_x, true, 0.0), "fixture").constant, 1.0, 0.03);
  EXPECT_NEAR(std::sqrt(scale) / named(scale_inputs(of, Sensor::accel_x), "fixture").constant, 1.0, 0.03);
  EXPECT_NEAR(std::sqrt(gyro) / named(bias_inputs(of, Sensor::gyro_x, true, cross), "fixture").constant, 1.0, 0.03);
}

UnitInput small_campaign(base::Random& random, int runs) {
  const auto truth = simulated::Truth::draw(random, Sensor::gyro_x);
  return simulated::campaign(truth, Sensor::gyro_x, runs, {}, random);
}

TEST(UncertaintyBudget, AFitListsAllSevenAndTheirSumIsTheBand) {
  base::Random random(5);
  UnitInput input = small_campaign(random, 4);
  input.type.temp_repeatability_c = 0.1;
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows);
  const auto fit = fit_sensor(*rows, Sensor::accel_x, {});
  ASSERT_TRUE(fit);
  std::vector<std::string> names;
  for (const Contribution& part : fit->bias.budget) names.push_back(part.name);
  EXPECT_EQ(names, (std::vector<std::string>{"noise", "run_to_run", "hysteresis", "thermometer", "gravity", "fixture",
                                             "model"}));
  for (const CurveFit* curve : {&fit->bias, &*fit->scale}) {
    for (std::size_t i = 0; i < curve->points.size(); ++i) {
      double variance = 0.0;
      for (const Contribution& part : curve->budget) variance += part.u.empty() ? 0.0 : part.u[i] * part.u[i];
      // Between the factors of infinitely many degrees of freedom and of three, and never the former alone.
      EXPECT_GT(curve->points[i].ci95, 1.95 * std::sqrt(variance));
      EXPECT_LT(curve->points[i].ci95, 3.19 * std::sqrt(variance));
      EXPECT_EQ(curve->points[i].ci95, expanded_uncertainty(curve->budget, Band::mean, i));
    }
  }
}

TEST(UncertaintyBudget, HysteresisIsHalfTheGapAndBelongsToAFreshPowerOnOnly) {
  base::Random random(6);
  UnitInput input = small_campaign(random, 4);
  constexpr double kHalfGap = 3e-4;  // rad/s
  for (RunInput& run : input.runs) {
    for (Segment& s : run.segments) s.sensor[0].mean += s.sweep == Sweep::up ? -kHalfGap : kHalfGap;
  }
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows);
  const auto fit = fit_sensor(*rows, Sensor::gyro_x, {});
  ASSERT_TRUE(fit);
  const Contribution& part = fit->bias.budget[2];
  EXPECT_TRUE(part.u.empty());
  EXPECT_NEAR(part.u_fresh[50], kHalfGap, 0.1 * kHalfGap);
  // One sweep alone cannot tell.
  for (RunInput& run : input.runs) {
    std::erase_if(run.segments, [](const Segment& s) { return s.sweep == Sweep::down; });
  }
  const auto one_way = fit_sensor(*make_rows(input), Sensor::gyro_x, {});
  ASSERT_TRUE(one_way);
  EXPECT_FALSE(one_way->bias.budget[2].stated());
}

TEST(UncertaintyBudget, TheRegistersGravityStandsInWhereTheSiteKnowsNone) {
  base::Random random(7);
  UnitInput input = small_campaign(random, 3);
  for (RunInput& run : input.runs) run.site = {};
  EXPECT_TRUE(make_rows(input)->gravity.assumed);
  ReferenceUse local;
  local.reference.kind = ReferenceKind::gravity;
  local.reference.correction = 9.8101;
  local.reference.standard_uncertainty = 2e-5;
  input.references = {local};
  const auto rows = make_rows(input);
  EXPECT_FALSE(rows->gravity.assumed);
  EXPECT_NEAR(rows->gravity.mps2, 9.8101, 1e-12);
  EXPECT_EQ(rows->gravity.standard_uncertainty_mps2, 2e-5);
}

ReferenceUse gravity_of(double mps2, double standard_uncertainty) {
  ReferenceUse use;
  use.reference.kind = ReferenceKind::gravity;
  use.reference.name = "pillar";
  use.reference.correction = mps2;
  use.reference.standard_uncertainty = standard_uncertainty;
  return use;
}

TEST(UncertaintyBudget, AReferencesUncertaintyIsNotThatOfAnotherNumber) {
  base::Random random(8);
  UnitInput input = small_campaign(random, 3);  // sites say 9.81
  input.references = {gravity_of(9.81, 1e-5)};
  EXPECT_EQ(make_rows(input)->gravity.standard_uncertainty_mps2, 1e-5);
  input.references = {gravity_of(9.78, 1e-5)};
  EXPECT_FALSE(make_rows(input)->gravity.standard_uncertainty_mps2);
}

TEST(UncertaintyBudget, TwoGravitiesOfTheRegisterAreRefusedWhereOneIsNeeded) {
  base::Random random(9);
  UnitInput input = small_campaign(random, 3);
  input.references = {gravity_of(9.81, 1e-5), gravity_of(9.78, 1e-5)};
  EXPECT_TRUE(make_rows(input));
  input.runs[1].site.gravity_mps2.reset();
  EXPECT_FALSE(make_rows(input));
}

TEST(UncertaintyBudget, OneRunWithoutAPairBringsTheFirstOrderOfItsFaces) {
  base::Random random(10);
  UnitInput input = small_campaign(random, 4);
  ReferenceUse squareness;
  squareness.reference.kind = ReferenceKind::fixture_squareness;
  squareness.reference.standard_uncertainty = 1e-3;
  input.references = {squareness};
  const auto fixture = [&] { return named(make_rows(input)->bias_type_b[3], "fixture").constant; };
  EXPECT_NEAR(fixture(), 9.81e-6 / std::numbers::sqrt2, 1e-9);
  std::erase_if(input.runs[2].segments, [](const Segment& s) { return s.key.position == "-X"; });
  EXPECT_NEAR(fixture(), 9.81e-3, 1e-8);
}

TEST(UncertaintyBudget, ACorrectionThatNobodyAppliesCounts) {
  Circumstances of = circumstances();
  ReferenceUse rate;
  rate.reference.kind = ReferenceKind::rate;
  rate.reference.standard_uncertainty = 30.0;
  rate.reference.correction = -400.0;
  of.references = {rate};
  EXPECT_NEAR(named(scale_inputs(of, Sensor::gyro_x), "fixture").constant, std::hypot(30.0, 400.0), 1e-9);
}

}  // namespace
}  // namespace soak::calib
