// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/uncertainty_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.h"
#include "calib/estimate/certificates.h"
#include "calib/estimate/site.h"
#include "calib/model/unit_model.h"
#include "tests/calib/campaign_simulation.h"

namespace soak::calib {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

TEST(UncertaintyBudget, ExpandsByStudentsTAtEffectiveDegreesOfFreedom) {
  // JCGM 100:2008, H.1 (end gauge): u_c = 32 nm, ν_eff = 16; there the 99 % t factor is 2.92, of 95 % it is 2.12. All
  // but the repeated readings are of type B there.
  const std::vector<Contribution> budget = {
      {.name = "standard", .type = 'B', .degrees_of_freedom = 18.0, .u = {25.0}},
      {.name = "repeated", .degrees_of_freedom = 24.0, .u = {5.8}},
      {.name = "random", .type = 'B', .degrees_of_freedom = 5.0, .u = {3.9}},
      {.name = "systematic", .type = 'B', .degrees_of_freedom = 8.0, .u = {6.7}},
      {.name = "expansion", .type = 'B', .degrees_of_freedom = 50.0, .u = {2.9}},
      {.name = "temperature", .type = 'B', .degrees_of_freedom = 2.0, .u = {16.6}}};
  const double u_c = std::sqrt(25.0 * 25.0 + 5.8 * 5.8 + 3.9 * 3.9 + 6.7 * 6.7 + 2.9 * 2.9 + 16.6 * 16.6);
  EXPECT_NEAR(expanded_uncertainty(budget, Band::mean, 0), 2.1199 * u_c, 1e-2);
  // Three are three, however the quotient is rounded.
  for (const double u : {0.1, 0.3, 1.0 / 7.0, 1e-9, 3e5}) {
    const std::vector<Contribution> runs = {{.name = "runs", .degrees_of_freedom = 3.0, .u = {u}}};
    EXPECT_NEAR(expanded_uncertainty(runs, Band::mean, 0) / u, 3.18245, 1e-4);
  }
}

/// How often the band of two parts holds their sum: normal, one of standard deviation 1 that is estimated from scatter
/// with `freedoms`, one of standard deviation `other` that is known.
double share_held(double freedoms, double other, base::Random& random) {
  constexpr int kDraws = 5000;
  int held = 0;
  for (int i = 0; i < kDraws; ++i) {
    double squares = 0.0;
    for (int k = 0; k < freedoms; ++k) squares += std::pow(random.gaussian(), 2);
    const std::vector<Contribution> budget = {
        {.name = "run_to_run", .degrees_of_freedom = freedoms, .u = {std::sqrt(squares / freedoms)}},
        {.name = "noise", .u = {other}}};
    const double error = random.gaussian() + other * random.gaussian();
    held += std::abs(error) <= expanded_uncertainty(budget, Band::mean, 0) ? 1 : 0;
  }
  return static_cast<double>(held) / kDraws;
}

TEST(UncertaintyBudget, ScatterOfFewRunsBesideKnownNoiseIsHeldAsOftenAsStated) {
  base::Random random(95);
  for (const double freedoms : {1.0, 2.0, 3.0}) {
    for (const double other : {0.2, 0.5, 1.0, 2.0}) {
      const double share = share_held(freedoms, other, random);
      // Four standard errors of so many draws are 1.2 %. Effective degrees of freedom of the sum, as JCGM 100 G.4 has
      // them, would hold 87.2 %, 92.2 % and 93.6 % at worst: three degrees of freedom still have those. Squares of
      // expanded parts would hold up to 98.7 and 97.7 %.
      EXPECT_GT(share, (freedoms < 3.0 ? 0.945 : 0.936) - 0.012) << freedoms << " " << other;
      EXPECT_LT(share, (freedoms < 2.0 ? 0.969 : 0.957) + 0.012) << freedoms << " " << other;
    }
  }
}

TEST(UncertaintyBudget, ScatterThatIsNotSeenAddsNothing) {
  // As of two rows whose slow scatter came out zero, with no degree of freedom left for it.
  const std::vector<Contribution> budget = {{.name = "noise", .u = {3.0}},
                                            {.name = "slow", .degrees_of_freedom = 0.0, .u = {0.0}}};
  EXPECT_NEAR(expanded_uncertainty(budget, Band::mean, 0), 1.95996 * 3.0, 1e-4);
  // Alone it counts as if it had one degree.
  const std::vector<Contribution> alone = {{.name = "slow", .degrees_of_freedom = 0.0, .u = {2.0}}};
  EXPECT_NEAR(expanded_uncertainty(alone, Band::mean, 0), 12.7062 * 2.0, 1e-3);
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
  constexpr int kDraws = 5000;
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
  const auto truth = simulated::Truth::draw(random);
  simulated::Scatter scatter;
  scatter.gyro_half_gap_rps = scatter.accel_half_gap_mps2 = 0.0;
  return simulated::campaign(truth, Sensor::gyro_x, runs, scatter, random);
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

ReferenceUse rate_of(double correction_ppm, double standard_uncertainty, std::vector<std::string> campaigns = {}) {
  ReferenceUse use;
  use.reference.kind = ReferenceKind::rate;
  use.reference.standard_uncertainty = standard_uncertainty;
  use.reference.correction = correction_ppm;
  use.campaigns = std::move(campaigns);
  return use;
}

TEST(UncertaintyBudget, ACorrectionCountsAsUncertaintyOnlyWhereItCannotBeApplied) {
  Circumstances of = circumstances();
  const auto fixture_ppm = [&] { return named(scale_inputs(of, Sensor::gyro_x), "fixture").constant; };
  of.references = {rate_of(-400.0, 30.0)};
  EXPECT_NEAR(fixture_ppm(), 30.0, 1e-9);
  of.references.push_back(rate_of(-400.0, 50.0));
  EXPECT_NEAR(fixture_ppm(), 50.0, 1e-9);
  of.references.push_back(rate_of(100.0, 10.0));
  EXPECT_NEAR(fixture_ppm(), std::hypot(50.0, 400.0), 1e-9);
  // Of two campaigns, each with a certificate of its own, the worse.
  of.campaigns = {"spring", "autumn"};
  of.references = {rate_of(-400.0, 30.0, {"spring"}), rate_of(100.0, 45.0, {"autumn"})};
  EXPECT_NEAR(fixture_ppm(), 45.0, 1e-9);
}

/// Scale of the gyros along x, each run's mean over its plateaus, ppm.
std::vector<double> gyro_scales_ppm(const UnitInput& input) {
  const auto rows = make_rows(input);
  if (!rows || !rows->scale[0]) return {};
  std::vector<double> sum(rows->scale[0]->runs.size());
  std::vector<double> count(sum.size());
  for (const CurveRow& row : rows->scale[0]->rows) {
    sum[static_cast<std::size_t>(row.run)] += row.value;
    count[static_cast<std::size_t>(row.run)] += 1.0;
  }
  for (std::size_t r = 0; r < sum.size(); ++r) sum[r] /= count[r];
  return sum;
}

/// A fixture that turns by 1000 ppm faster than it says gives gyros 1000 ppm of scale that they do not have.
TEST(Certificates, ARateIsCorrectedRunByRunAsItsCampaignsCertificateSays) {
  base::Random random(11);
  const auto truth = simulated::Truth::draw(random);
  simulated::Scatter scatter;
  scatter.rate_ppm = scatter.gyro_noise_rps = scatter.gyro_visit_rps = scatter.thermometer_c = 0.0;
  scatter.rate_correction_ppm = 1000.0;
  scatter.face_tilt_rad = scatter.level_rad = 0.0;
  UnitInput input = simulated::campaign(truth, Sensor::gyro_x, 2, scatter, random);
  double mean_ppm = 0.0;  // of the truth, over the visits of a run
  for (int visit = 0; visit < 41; ++visit) {
    mean_ppm += truth.gyro_scale.at(-30.0 + 5.0 * (visit <= 20 ? visit : 40 - visit)) / 41.0;
  }
  // The curve between a set point and where the unit settles: 0.2 K of at most 110 ppm/K.
  constexpr double kSettled_ppm = 10.0;
  for (const double scale : gyro_scales_ppm(input)) EXPECT_NEAR(scale, mean_ppm + 1000.0, kSettled_ppm);
  input.references = {rate_of(1000.0, 20.0)};
  for (const double scale : gyro_scales_ppm(input)) EXPECT_NEAR(scale, mean_ppm, kSettled_ppm);
  // Two campaigns with a certificate each: the second one's is 600 ppm short.
  input.runs[0].campaign = "spring";
  input.runs[1].campaign = "autumn";
  input.references = {rate_of(1000.0, 20.0, {"spring"}), rate_of(400.0, 20.0, {"autumn"})};
  const auto scales = gyro_scales_ppm(input);
  ASSERT_EQ(scales.size(), 2U);
  EXPECT_NEAR(scales[0], mean_ppm, kSettled_ppm);
  EXPECT_NEAR(scales[1], mean_ppm + 600.0, kSettled_ppm);
  // What cannot be decided is not applied.
  for (ReferenceUse& use : input.references) use.campaigns.clear();
  for (const double scale : gyro_scales_ppm(input)) EXPECT_NEAR(scale, mean_ppm + 1000.0, kSettled_ppm);
}

TEST(Certificates, AVoltageIsCorrectedAndAHoleInTheLogStaysOne) {
  std::vector<double> supply_v = {4.9, std::nan(""), 5.1};
  ReferenceUse meter;
  meter.reference.kind = ReferenceKind::supply;
  meter.reference.correction = 0.25;
  meter.campaigns = {"spring"};
  correct_supply(supply_v, std::vector{meter}, "autumn");
  EXPECT_EQ(supply_v[0], 4.9);
  correct_supply(supply_v, std::vector{meter}, "spring");
  EXPECT_NEAR(supply_v[0], 5.15, 1e-12);
  EXPECT_TRUE(std::isnan(supply_v[1]));
  EXPECT_NEAR(supply_v[2], 5.35, 1e-12);
}

TEST(Certificates, TheVoltmeterBearsOnTheBiasOfSensorsThatFollowTheSupply) {
  base::Random random(12);
  UnitInput input = small_campaign(random, 3);
  simulated::Scatter scatter;
  simulated::state(input, scatter);
  auto rows = make_rows(input);
  ASSERT_TRUE(rows);
  EXPECT_NEAR(named(rows->bias_type_b[0], "supply").constant, scatter.gyro_per_v * scatter.supply_v, 1e-15);
  std::erase_if(input.references, [](const ReferenceUse& use) { return use.reference.kind == ReferenceKind::supply; });
  rows = make_rows(input);
  EXPECT_FALSE(named(rows->bias_type_b[0], "supply").stated);
  input.terms.clear();
  rows = make_rows(input);
  EXPECT_THROW(named(rows->bias_type_b[0], "supply"), std::runtime_error);
}

/// Faces that lean by 0.3° read 50 mm/s² more or less where they are horizontal.
TEST(Certificates, KnownAnglesOfTheFacesComeOutOfMisalignmentAndEvenOrder) {
  base::Random random(13);
  const auto truth = simulated::Truth::draw(random);
  simulated::Scatter scatter;
  scatter.face_tilt_rad = scatter.level_rad = scatter.thermometer_c = scatter.gravity_mps2 = 0.0;
  scatter.accel_noise_mps2 = 1e-4;
  scatter.accel_visit_mps2 = 0.0;
  scatter.face_lean_rad = 0.3 * kRad;
  UnitInput input = simulated::campaign(truth, Sensor::gyro_x, 2, scatter, random);
  const auto worst = [&] {
    const auto rows = make_rows(input);
    double largest = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      largest = std::max(largest, std::abs(rows->even_order[i]->value) * 9.81);
      for (std::size_t j = 0; j < 3; ++j) {
        const double off = (*rows->accel_misalignment)[i][j].value - truth.misalignment[i][j];
        if (i != j) largest = std::max(largest, std::abs(off));
      }
    }
    return largest;
  };
  EXPECT_LT(worst(), 2e-5);
  for (RunInput& run : input.runs) {
    for (Segment& s : run.segments) {
      if (!turns(s)) s.position = position_named(s.position->label);
    }
  }
  EXPECT_GT(worst(), 1e-3);
}

/// A lean of the base shows in full, or not at all: by the headings of an axis while another one points up and down.
TEST(TypeB, TheLevelCountsInFullInMisalignmentUnlessItWasEstimated) {
  UnitRows rows;
  rows.gravity = {9.81, false, 3e-4, "stated"};
  rows.accel_misalignment.emplace();
  rows.even_order[0].emplace();
  Circumstances of = circumstances();
  ReferenceUse level;
  level.reference.kind = ReferenceKind::level;
  level.reference.standard_uncertainty = 0.2 * kRad;
  of.references.push_back(level);
  of.runs = 4;
  const auto type_b = [&] {
    state_type_b(of, rows);
    return *(*rows.accel_misalignment)[0][1].type_b;
  };
  EXPECT_NEAR(type_b(), std::hypot(0.1 / std::numbers::sqrt2, 0.2) * kRad, 1e-12);
  EXPECT_NEAR(*rows.even_order[0]->type_b, std::hypot(0.05, 0.2 / std::numbers::sqrt2) * kRad / 9.81, 1e-12);
  rows.level.in_every_run = true;
  EXPECT_NEAR(type_b(), 0.1 / std::numbers::sqrt2 * kRad, 1e-12);
  EXPECT_NEAR(*rows.even_order[0]->type_b, 0.05 * kRad / 9.81, 1e-12);
}

}  // namespace
}  // namespace soak::calib
