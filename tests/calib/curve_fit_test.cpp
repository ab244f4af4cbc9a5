// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/curve_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>

#include "base/random.h"
#include "calib/curve/families.h"

namespace soak::calib {
namespace {

/// A gyro's drift in deg/s: a smooth curve that spans about 0.5 with a sudden local feature [AH05 §6.3].
double truth_at(double temp_c) {
  return 0.25 * std::atan((temp_c - 15.0) / 25.0) / 0.9 + 0.1 * std::exp(-0.5 * std::pow((temp_c - 34.0) / 7.0, 2));
}

struct Campaign {
  int runs = 4;
  double run_sigma = 0.02;
  double noise = 0.002;
  double half_gap = 0.0;  ///< heating reads so much more than the mean, cooling so much less
  std::uint64_t seed = 1;
};

CurveData make_data(const Campaign& campaign) {
  CurveData data;
  base::Random random(campaign.seed, 11);
  for (int run = 0; run < campaign.runs; ++run) {
    data.runs.push_back("R" + std::to_string(run + 1));
    const double offset = campaign.run_sigma * random.gaussian();
    double t_s = 0.0;
    for (int visit = 0; visit < 41; ++visit) {
      const bool up = visit < 21;
      const double level_c = up ? -30.0 + 5.0 * visit : 70.0 - 5.0 * (visit - 20);
      const double temp_c = level_c + 0.3 * random.gaussian();
      CurveRow row{run,
                   2 * run + (up ? 0 : 1),
                   up ? Sweep::up : Sweep::down,
                   t_s += 1800.0,
                   temp_c,
                   truth_at(temp_c) + offset + (up ? 1 : -1) * campaign.half_gap + campaign.noise * random.gaussian(),
                   campaign.noise};
      data.rows.push_back(row);
    }
    for (const char* sweep : {" up", " down"}) data.branches.push_back(data.runs.back() + sweep);
  }
  return data;
}

CurveFit fit(const CurveData& data, std::optional<int> rules = {}) {
  auto result = fit_curve(data, {rules}, {"gyro_x", "deg/s", 1.0});
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

/// Largest error against the truth between −29 and 69 °C, its mean removed.
double worst_shape_error(const CurveFit& fit) {
  std::vector<double> errors;
  double mean = 0.0;
  for (double t = -29.0; t <= 69.0; t += 0.25) errors.push_back(evaluate(fit.curve, t) - truth_at(t));
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  double worst = 0.0;
  for (const double e : errors) worst = std::max(worst, std::abs(e - mean));
  return worst;
}

bool has_warning(const CurveFit& fit, const std::string& code) {
  return std::any_of(fit.warnings.begin(), fit.warnings.end(), [&](const Warning& w) { return w.code == code; });
}

/// Error on one run of an ANFIS that knows nothing of it: rules chosen and trained anew from the others.
double error_without(const CurveData& data, int run) {
  std::vector<bool> others;
  for (const CurveRow& row : data.rows) others.push_back(row.run != run);
  const auto trained = train_families(select(data, others), {}, RuleChoice::folds_over_runs);
  if (!trained) throw std::runtime_error(trained.error().message);
  double squares = 0.0;
  int count = 0;
  for (const CurveRow& row : data.rows) {
    if (row.run != run) continue;
    squares += std::pow(row.value - evaluate((*trained)[Family::anfis]->curve, row.temp_c), 2);
    ++count;
  }
  return std::sqrt(squares / count);
}

double reported_error(const CurveFit& fit, int run) {
  return *fit.checks[static_cast<std::size_t>(run)].rmse[static_cast<std::size_t>(Family::anfis)];
}

TEST(CurveFit, HeldOutErrorIsThatOfAFitWhichHasNeverSeenTheRun) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const CurveData data = make_data({.noise = 0.01, .seed = seed});
    const CurveFit four = fit(data);
    double ratio = 0.0;
    for (int run = 0; run < 4; ++run) ratio += reported_error(four, run) / error_without(data, run) / 4.0;
    EXPECT_NEAR(ratio, 1.0, 0.03) << seed;
  }
}

TEST(CurveFit, ARunOfAnotherShapeIsNotFollowedByTheFoldThatLeavesItOut) {
  CurveData data = make_data({.noise = 0.001, .seed = 5});
  for (CurveRow& row : data.rows) {
    if (row.run == 2) row.value += 0.1 * std::exp(-0.5 * std::pow((row.temp_c + 5.0) / 6.0, 2));
  }
  const CurveFit four = fit(data);
  EXPECT_NEAR(reported_error(four, 2) / error_without(data, 2), 1.0, 0.03);
  // The RMS of the bump over 41 visits.
  EXPECT_GT(reported_error(four, 2), 0.02);
}

TEST(CurveFit, RunsThatShareNoTemperatureJudgeAllFamilies) {
  // Each run visits every fourth plateau: without one of them too few are left for the most rules that all carry.
  CurveData data = make_data({.run_sigma = 0.002, .noise = 0.001, .seed = 3});
  std::erase_if(data.rows, [](const CurveRow& row) {
    return static_cast<int>(std::lround((row.temp_c + 30.0) / 5.0)) % 4 != row.run;
  });
  const CurveFit staggered = fit(data);
  ASSERT_EQ(staggered.checks.size(), 4U);
  for (const FoldErrors& fold : staggered.checks) {
    for (std::size_t family = 0; family < kFamilyCount; ++family) EXPECT_TRUE(fold.rmse[family]) << fold.fold;
  }
}

TEST(CurveFit, FollowsTheShapeBetweenThePlateaus) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CurveFit result = fit(make_data({.seed = seed}));
    // One hundredth of the uncompensated span of 0.5 [AH05 §6.4.3].
    EXPECT_LT(worst_shape_error(result), 0.005) << name_of(result.deployed) << " seed " << seed;
  }
}

TEST(CurveFit, StatesTheRunToRunScatterThatItCannotRemove) {
  const CurveFit result = fit(make_data({.runs = 12, .seed = 4}));
  EXPECT_NEAR(*result.run_to_run_sigma, 0.02, 0.01);
  const auto& error = result.cross_validation[static_cast<std::size_t>(Family::anfis)];
  ASSERT_TRUE(error);
  EXPECT_GT(error->rmse_abs, 0.01);
  // The shape error of a held-out run is little more than the noise of its rows.
  EXPECT_LT(error->rmse_shape, 0.003);
  EXPECT_EQ(result.holdout, "run");
  EXPECT_EQ(result.checks.size(), 12U);
}

TEST(CurveFit, BandCoversTheTruthOfTheMeanCurve) {
  int inside = 0;
  int inside_fresh = 0;
  int count = 0;
  int fresh = 0;
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    const CurveFit result = fit(make_data({.runs = 4, .seed = 100 + seed}), 8);
    const double power_on = 0.02 * base::hashed_gaussian(seed, 99, 0);
    for (const CurvePoint& p : result.points) {
      inside += std::abs(p.value - truth_at(p.temp_c)) <= p.ci95 ? 1 : 0;
      inside_fresh += std::abs(p.value - truth_at(p.temp_c) - power_on) <= *p.pi95 ? 1 : 0;
      ++count;
      ++fresh;
    }
  }
  // 40 campaigns, dominated by the runs' mean offset: one standard error of a coverage of 95 % is 3.4 %.
  EXPECT_GT(static_cast<double>(inside) / count, 0.88);
  EXPECT_GT(static_cast<double>(inside_fresh) / fresh, 0.88);
  EXPECT_LT(static_cast<double>(inside) / count, 0.999);
}

TEST(CurveFit, WarnsWhereHeatingAndCoolingDiffer) {
  EXPECT_TRUE(has_warning(fit(make_data({.half_gap = 0.01})), "hysteresis"));
  EXPECT_FALSE(has_warning(fit(make_data({})), "hysteresis"));
}

TEST(CurveFit, GivesNoHeldOutErrorUnderThreeRuns) {
  const CurveFit two = fit(make_data({.runs = 2}));
  EXPECT_FALSE(two.cross_validation[0]);
  EXPECT_EQ(two.holdout, "branch");
  EXPECT_EQ(two.checks.size(), 4U);
  EXPECT_TRUE(has_warning(two, "few_runs"));
  const CurveFit one = fit(make_data({.runs = 1}));
  EXPECT_FALSE(one.run_to_run_sigma);
  EXPECT_FALSE(one.points.front().pi95);
}

/// Power-ons that stay at 25 °C, each with a level of its own.
void add_power_ons_at_one_plateau(CurveData& data, int count, const Campaign& campaign) {
  base::Random random(campaign.seed, 12);
  for (int i = 0; i < count; ++i) {
    const int run = static_cast<int>(data.runs.size());
    data.runs.push_back("R" + std::to_string(run + 1));
    const double temp_c = 25.0 + 0.1 * random.gaussian();
    const double value = truth_at(temp_c) + campaign.run_sigma * random.gaussian() + campaign.noise * random.gaussian();
    data.rows.push_back(
        {run, static_cast<int>(data.branches.size()), Sweep::unknown, 0.0, temp_c, value, campaign.noise});
    data.branches.push_back(data.runs.back());
  }
}

TEST(CurveFit, PowerOnsAtOnePlateauLeaveTheShapeOfASinglePassAsItIs) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Campaign campaign{.runs = 1, .seed = seed};
    CurveData data = make_data(campaign);
    const double alone = worst_shape_error(fit(data));
    add_power_ons_at_one_plateau(data, 19, campaign);
    const CurveFit result = fit(data);
    EXPECT_LT(worst_shape_error(result), 1.5 * alone) << name_of(result.deployed) << " seed " << seed;
    EXPECT_NE(result.holdout, "run");
    EXPECT_TRUE(has_warning(result, "few_runs"));
  }
}

TEST(CurveFit, AHeldOutPowerOnAtOnePlateauIsNoProofOfTheShape) {
  const Campaign campaign{.runs = 5, .seed = 2};
  CurveData data = make_data(campaign);
  const auto error_of = [](const CurveFit& of) { return of.deployed_error().value().rmse_shape; };
  const CurveFit passes = fit(data);
  add_power_ons_at_one_plateau(data, 12, campaign);
  const CurveFit result = fit(data);
  EXPECT_EQ(result.checks.size(), 5U);
  // The same five runs are held out: twelve zeros among their errors would make it a quarter less.
  EXPECT_NEAR(error_of(result), error_of(passes), 0.1 * error_of(passes));
}

// The mean over power-ons scatters by the scatter of one over the root of their number, wherever they were.
TEST(CurveFit, PowerOnsAtOnePlateauAverageTheLevelLikeWholeRuns) {
  constexpr int kCampaigns = 30;
  double squares = 0.0;
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
    const Campaign campaign{.runs = 3, .seed = 300 + seed};
    CurveData data = make_data(campaign);
    add_power_ons_at_one_plateau(data, 17, campaign);
    const CurveFit result = fit(data, 6);
    double mean = 0.0;
    for (const CurvePoint& p : result.points) {
      mean += (p.value - truth_at(p.temp_c)) / static_cast<double>(result.points.size());
    }
    squares += mean * mean;
    const CurvePoint& middle = result.points[result.points.size() / 2];
    inside += std::abs(middle.value - truth_at(middle.temp_c)) <= middle.ci95 ? 1 : 0;
  }
  // 0.02/√20, and its 95 % interval by chi-squared with 30 degrees of freedom; 95 % of 30 less three standard errors.
  EXPECT_GT(std::sqrt(squares / kCampaigns), 0.00447 * std::sqrt(16.79 / 30.0));
  EXPECT_LT(std::sqrt(squares / kCampaigns), 0.00447 * std::sqrt(46.98 / 30.0));
  EXPECT_GE(inside, 25);
}

TEST(CurveFit, TracesTheRangeOfItsRowsDegreeByDegree) {
  const CurveData data = make_data({});
  const CurveFit result = fit(data, 6);
  const auto [low, high] = std::minmax_element(data.rows.begin(), data.rows.end(),
                                               [](const auto& a, const auto& b) { return a.temp_c < b.temp_c; });
  EXPECT_EQ(result.points.front().temp_c, low->temp_c);
  EXPECT_EQ(result.points.back().temp_c, high->temp_c);
  for (std::size_t i = 1; i + 1 < result.points.size(); ++i) {
    EXPECT_NEAR(result.points[i].temp_c - result.points[i - 1].temp_c, 1.0, 1e-9);
  }
}

TEST(CurveFit, DeploysABaselineThatWinsOnHeldOutRuns) {
  // Two rules cannot follow the feature, the spline can.
  const CurveFit result = fit(make_data({}), 2);
  EXPECT_EQ(result.deployed, Family::spline);
  EXPECT_TRUE(has_warning(result, "baseline_deployed"));
}

TEST(CurveFit, RefusesAConstantSensor) {
  CurveData data = make_data({});
  for (CurveRow& row : data.rows) row.value = 0.0;
  const auto result = fit_curve(data, {}, {"gyro_x", "deg/s", 1.0});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
}

TEST(CurveFit, RefusesFewerThanThreeTemperatures) {
  CurveData data = make_data({});
  for (CurveRow& row : data.rows) row.temp_c = row.temp_c < 20.0 ? -30.0 : 70.0;
  const auto result = fit_curve(data, {}, {"gyro_x", "deg/s", 1.0});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
}

TEST(CurveFit, DeploysTheSplineWhereTemperaturesAreTooFewForRules) {
  CurveData data = make_data({});
  std::erase_if(data.rows, [](const CurveRow& row) { return row.temp_c > -12.0; });
  const CurveFit result = fit(data);
  EXPECT_EQ(result.rules, 0);
  EXPECT_EQ(result.deployed, Family::spline);
  EXPECT_TRUE(has_warning(result, "few_temperatures"));
}

/// Four short runs over seven plateaus, heating and cooling: few rows, so that the number of rules is chosen anew in
/// each fold and may differ from that of the whole.
CurveData short_campaign(std::uint64_t seed) {
  CurveData data;
  base::Random random(seed, 12);
  const double centre_c = 10.0 + 20.0 * random.gaussian();
  const double height = 0.05 * random.gaussian();
  for (int run = 0; run < 4; ++run) {
    data.runs.push_back("R" + std::to_string(run + 1));
    const double offset = 0.006 * random.gaussian();
    for (int visit = 0; visit < 13; ++visit) {
      const bool up = visit < 7;
      const double temp_c = (up ? -20.0 + 15.0 * visit : 70.0 - 15.0 * (visit - 6)) + 0.3 * random.gaussian();
      const double bump = height * std::exp(-0.5 * std::pow((temp_c - centre_c) / 15.0, 2));
      const double value = -0.15 * std::tanh((temp_c - 20.0) / 40.0) + bump + offset + 0.001 * random.gaussian();
      data.rows.push_back(
          {run, 2 * run + (up ? 0 : 1), up ? Sweep::up : Sweep::down, 1800.0 * (visit + 1), temp_c, value, 0.001});
    }
    for (const char* sweep : {" up", " down"}) data.branches.push_back(data.runs.back() + sweep);
  }
  return data;
}

/// RMS of rows less curve, each run's mean taken out.
double shape_error(const CurveFit& fit, const CurveData& data) {
  double squares = 0.0;
  for (int run = 0; run < 4; ++run) {
    std::vector<double> errors;
    for (const CurveRow& row : data.rows) {
      if (row.run != run) continue;
      double at = 0.0;
      evaluate(fit.curve, std::span(&row.temp_c, 1), std::span(&at, 1));
      errors.push_back(row.value - at);
    }
    const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    for (const double error : errors) squares += (error - mean) * (error - mean);
  }
  return std::sqrt(squares / static_cast<double>(data.rows.size()));
}

TEST(CurveFit, WhatIsDeployedFitsItsRowsAsWellAsTheHeldOutRunsPromised) {
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    const CurveData data = short_campaign(seed);
    const CurveFit fitted = fit(data);
    const auto promised = fitted.cross_validation[static_cast<std::size_t>(fitted.deployed)];
    ASSERT_TRUE(promised);
    // Runs that were left out are never fitted better than those that were not.
    EXPECT_LT(shape_error(fitted, data), 1.25 * promised->rmse_shape)
        << "seed " << seed << " " << name_of(fitted.deployed);
  }
}

}  // namespace
}  // namespace soak::calib
