// SPDX-License-Identifier: Apache-2.0
// Nested noise: its estimation from replicates and the whitening with it.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "anfis/linear/least_squares.h"
#include "calib/gap/base/campaign_model.h"
#include "calib/gap/base/whitened_base.h"
#include "calib/gap/noise/noise.h"
#include "calib/gap/noise/wander_estimate.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

TEST(NoiseComponents, AreThoseOfTheCampaign) {
  made_up::Plan plan;
  plan.runs = 20;
  const auto campaign = made_up::campaign(plan, made_up::nothing());
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  const CampaignModel model(observations, history);
  for (const Sensor sensor : kSensors) {
    const double block = is_gyro(sensor) ? plan.gyro_block : plan.accel_block;
    const NoiseComponents& noise = model.residuals().noise[index_of(sensor)];
    EXPECT_TRUE(noise.replicated);
    EXPECT_NEAR(noise.block / block, 1.0, 0.05) << name_of(sensor);
    EXPECT_NEAR(noise.placement / block, 0.5, 0.1) << name_of(sensor);
    EXPECT_NEAR(noise.visit / block, 0.5, 0.12) << name_of(sensor);
  }
}

// What every run repeats is no noise, however large.
TEST(NoiseComponents, LeaveOutWhatTheRunsShare) {
  made_up::Plan plan;
  const auto shared = [&](Sensor sensor, const made_up::Moment& moment) {
    return (is_gyro(sensor) ? plan.gyro_block : plan.accel_block) * 5.0 * std::sin(1.7 * moment.visit);
  };
  const auto campaign = made_up::campaign(plan, shared);
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  const CampaignModel model(observations, history);
  EXPECT_NEAR(model.residuals().noise[0].visit / plan.gyro_block, 0.5, 0.25);
}

TEST(Whitening, MakesNestedNoiseWhite) {
  made_up::Plan plan;
  plan.runs = 2;
  plan.levels = 2;
  const Observations observations = observe(made_up::campaign(plan, made_up::nothing()));
  NoiseComponents noise;
  noise.block = 1.0;
  noise.placement = 0.7;
  noise.visit = 1.3;
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const Observation& first = observations.rows[static_cast<std::size_t>(a)];
      const Observation& second = observations.rows[static_cast<std::size_t>(b)];
      if (first.run == second.run && first.visit == second.visit) covariance(a, b) += 1.3 * 1.3;
      if (first.placement == second.placement) covariance(a, b) += 0.7 * 0.7;
      if (a == b) covariance(a, b) += 1.0;
    }
  }
  const Whitening whitening(observations, Sensor::gyro_x, noise, std::vector<bool>(observations.rows.size(), true));
  const Eigen::MatrixXd half = whitening.apply(covariance);
  const Eigen::MatrixXd white = whitening.apply(half.transpose());
  EXPECT_LT((white - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-10);
}

// By the dense covariance, which the filter never makes.
TEST(Whitening, MakesNoiseWhiteThatWandersOnTop) {
  made_up::Plan plan;
  plan.runs = 2;
  plan.levels = 2;
  const Observations observations = observe(made_up::campaign(plan, made_up::nothing()));
  NoiseComponents noise;
  noise.block = 1.0;
  noise.placement = 0.7;
  noise.visit = 1.3;
  noise.wander = {{500.0, 0.9}, {9000.0, 2.0}};
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const Observation& first = observations.rows[static_cast<std::size_t>(a)];
      const Observation& second = observations.rows[static_cast<std::size_t>(b)];
      if (first.run != second.run) continue;
      const double apart_s = std::abs(first.t_s - second.t_s);
      covariance(a, b) += 0.81 * std::exp(-apart_s / 500.0) + 4.0 * std::exp(-apart_s / 9000.0);
      if (first.visit == second.visit) covariance(a, b) += 1.3 * 1.3;
      if (first.placement == second.placement) covariance(a, b) += 0.7 * 0.7;
    }
  }
  const Whitening whitening(observations, Sensor::gyro_x, noise, std::vector<bool>(observations.rows.size(), true));
  const Eigen::MatrixXd half = whitening.apply(covariance);
  const Eigen::MatrixXd white = whitening.apply(half.transpose());
  EXPECT_LT((white - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-9);
}

/// The filter of a made-up campaign of three runs, and where the rows of the last of them are.
struct FilteredRuns {
  Observations observations;
  Whitening whitening;
  Eigen::Index first = 0;  ///< of the last run

  [[nodiscard]] Eigen::Index count() const { return static_cast<Eigen::Index>(whitening.rows().size()) - first; }
};

FilteredRuns three_filtered_runs() {
  made_up::Plan plan;
  plan.runs = 3;
  plan.levels = 2;
  Observations observations = observe(made_up::campaign(plan, made_up::nothing()));
  std::vector<bool> keep(observations.rows.size(), true);
  keep[4] = false;  // whitened rows are no longer those of the observations
  const Whitening whitening(observations, Sensor::gyro_x, {1.0, 0.7, 1.3, 0.0, 0.0, 0.0, false, {{500.0, 0.9}}}, keep);
  const auto first = std::ranges::find_if(
      whitening.rows(), [&](Eigen::Index row) { return observations.rows[static_cast<std::size_t>(row)].run == 2; });
  return {std::move(observations), whitening, first - whitening.rows().begin()};
}

TEST(Whitening, OfALaterRunByItselfIsThatOfAllRuns) {
  const FilteredRuns runs = three_filtered_runs();
  ASSERT_GT(runs.first, 0);
  const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(static_cast<Eigen::Index>(runs.observations.rows.size()), 6);
  const Eigen::MatrixXd alone = runs.whitening.apply_in_run(columns, runs.first, runs.count());
  EXPECT_EQ(alone, runs.whitening.apply(columns).middleRows(runs.first, runs.count()));
}

// Columns go through the filter four, eight or sixteen at a time.
TEST(Whitening, OfManyColumnsIsThatOfEachByItself) {
  const FilteredRuns runs = three_filtered_runs();
  for (const Eigen::Index width : {1, 4, 5, 8, 9, 16, 17}) {
    const Eigen::MatrixXd columns =
        Eigen::MatrixXd::Random(static_cast<Eigen::Index>(runs.observations.rows.size()), width);
    const Eigen::MatrixXd white = runs.whitening.apply(columns);
    for (Eigen::Index k = 0; k < width; ++k) {
      EXPECT_EQ(white.col(k), runs.whitening.apply(columns.col(k)).col(0)) << k << " of " << width;
    }
  }
}

/// What WhitenedBase::solve() is to give, by QR of the columns with the prior's rows below.
Eigen::VectorXd by_qr(const WhitenedBase& base, const Eigen::VectorXd& prior, Eigen::MatrixXd& covariance) {
  Eigen::MatrixXd columns(base.columns().rows() + prior.size(), prior.size());
  columns << base.columns(), Eigen::MatrixXd(prior.asDiagonal());
  Eigen::VectorXd readings = Eigen::VectorXd::Zero(columns.rows());
  readings.head(base.readings().size()) = base.readings();
  const anfis::LeastSquaresFit fit = anfis::solve_least_squares(columns, readings);
  covariance = fit.covariance_factor * fit.covariance_factor.transpose();
  return fit.coefficients;
}

TEST(WhitenedBase, SolvesNormalEquationsToWhatQrGives) {
  const FilteredRuns runs = three_filtered_runs();
  const auto rows = static_cast<Eigen::Index>(runs.observations.rows.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Random(rows, 5);
  columns.col(1) *= 1e6;                                    // units differ
  columns.col(2) = columns.col(0) + 0.01 * columns.col(2);  // nearly another column
  const WhitenedBase base(runs.whitening, columns, Eigen::VectorXd::Random(rows));
  const Eigen::VectorXd prior = (Eigen::VectorXd(5) << 0.0, 0.0, 0.0, 3.0, 0.0).finished();
  const anfis::LeastSquaresFit fit = base.solve(prior);
  Eigen::MatrixXd covariance;
  const Eigen::VectorXd expected = by_qr(base, prior, covariance);
  const Eigen::MatrixXd own = fit.covariance_factor * fit.covariance_factor.transpose();
  for (Eigen::Index k = 0; k < 5; ++k) {
    EXPECT_NEAR(fit.coefficients(k), expected(k), 1e-9 * std::sqrt(covariance(k, k))) << k;
    EXPECT_NEAR(own(k, k), covariance(k, k), 1e-8 * covariance(k, k)) << k;
  }
}

/// Half the mean square of the difference of two placements' means, blocks left out: what an Allan variance shows at
/// that distance. Within a visit (18 minutes here) what the visit has of its own does not differ.
double half_square_of_change(const NoiseComponents& noise, double apart_s, bool same_visit) {
  double sum = noise.placement * noise.placement + (same_visit ? 0.0 : noise.visit * noise.visit);
  for (const GaussMarkov& process : noise.wander) {
    sum += process.sigma * process.sigma * (1.0 - std::exp(-apart_s / process.tau_s));
  }
  return sum;
}

/// Noise of each sensor of a campaign in which something wanders, over that of a block.
KnownNoise estimated(const made_up::Plan& plan, const LoggedCampaign& campaign) {
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  const CampaignModel model(observations, history);
  const Eigen::MatrixXd none(static_cast<Eigen::Index>(observations.rows.size()), 0);
  const WanderEstimate estimate(observations, model.remainder(Sensor::gyro_x), none);
  KnownNoise noise;
  for (const Sensor sensor : kSensors) {
    EXPECT_TRUE(estimate.is_for(model.remainder(sensor)));
    NoiseComponents& own = noise[index_of(sensor)];
    own = estimate.of(model.remainder(sensor), model.residuals().noise[index_of(sensor)]).value();
    const double unit = made_up::unit_of(plan, sensor);
    for (double* sigma : {&own.block, &own.placement, &own.visit}) *sigma /= unit;
    for (GaussMarkov& process : own.wander) process.sigma /= unit;
  }
  return noise;
}

// The processes differ from those that the estimate is made of: what counts is how far the bias gets in which time.
TEST(WanderEstimate, FindsHowFarABiasWandersInWhichTime) {
  made_up::Plan plan;
  plan.runs = 20;
  plan.visit_share = 0.0;
  const KnownNoise noise = estimated(plan, made_up::campaign(plan, made_up::wander(plan, 1.5, {900.0, 15000.0}, 7)));
  double near = 0.0;
  double far = 0.0;
  for (const NoiseComponents& own : noise) {
    EXPECT_NEAR(own.block, 1.0, 0.1);
    near += half_square_of_change(own, 600.0, true) / kSensorCount;
    far += half_square_of_change(own, 10000.0, false) / kSensorCount;
  }
  // A placement's own scatter is half a block's.
  const auto truth = [](double apart_s) {
    return 0.25 + 1.125 * (2.0 - std::exp(-apart_s / 900.0) - std::exp(-apart_s / 15000.0));
  };
  EXPECT_NEAR(near / truth(600.0), 1.0, 0.2);
  EXPECT_NEAR(far / truth(10000.0), 1.0, 0.2);
}

TEST(WanderEstimate, FindsLittleWhereNothingWanders) {
  made_up::Plan plan;
  plan.runs = 20;
  double placement = 0.0;
  double visit = 0.0;
  for (const NoiseComponents& own : estimated(plan, made_up::campaign(plan, made_up::nothing()))) {
    placement += own.placement * own.placement / kSensorCount;
    visit += (half_square_of_change(own, 3000.0, false) - own.placement * own.placement) / kSensorCount;
  }
  EXPECT_NEAR(placement, 0.25, 0.08);
  EXPECT_NEAR(visit, 0.25, 0.08);
}

TEST(WanderEstimate, NeedsRunsThatRepeatEachOther) {
  made_up::Plan plan;
  plan.runs = 1;
  const Observations observations = observe(made_up::campaign(plan, made_up::nothing()));
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  const WanderEstimate estimate(observations, Eigen::VectorXd::Random(n), Eigen::MatrixXd(n, 0));
  EXPECT_FALSE(estimate.of(Eigen::VectorXd::Random(n), {}));
}

// By the sum over all pairs of rows.
TEST(VarianceAboutMean, IsThatOfTheProcessLessThatOfItsMean) {
  const Observations observations = observe(made_up::campaign(made_up::Plan(), made_up::nothing()));
  const std::vector<GaussMarkov> wander = {{700.0, 2.0}, {30000.0, 3.0}};
  double expected = 0.0;
  double rows = 0.0;
  double covariance = 0.0;
  for (const Observation& a : observations.rows) {
    if (a.run != 1) continue;
    rows += 1.0;
    for (const Observation& b : observations.rows) {
      if (b.run != 1) continue;
      for (const GaussMarkov& process : wander) {
        covariance += process.sigma * process.sigma * std::exp(-std::abs(a.t_s - b.t_s) / process.tau_s);
      }
    }
  }
  expected = 13.0 - covariance / (rows * rows);
  EXPECT_NEAR(variance_about_mean(observations, wander, 1), expected, 1e-9);
}

}  // namespace
}  // namespace soak::calib::gap
