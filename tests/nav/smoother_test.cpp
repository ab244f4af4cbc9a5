// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/smoother.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/random.h"
#include "matched_drives.h"
#include "nav/filter/filter_run.h"
#include "tests/long_tests.h"

namespace soak::nav {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A body on a line, pushed at random: place and speed each second, its place measured now and then.
struct Line {
  Matrix2d phi{{1.0, 1.0}, {0.0, 1.0}};
  Matrix2d q{{0.4, 0.5}, {0.5, 1.0}};
  Vector2d start{3.0, -1.0};
  Matrix2d start_covariance{{4.0, 0.3}, {0.3, 1.0}};
  double variance = 0.25;
  std::vector<std::optional<double>> places;  ///< at 1, 2, ... s
};

Line pushed_line() {
  Line line;
  base::Random random(11);
  for (int k = 1; k <= 15; ++k) {
    const bool is_measured = k < 5 || k > 9;
    line.places.push_back(is_measured ? std::optional(2.0 * k + random.gaussian()) : std::nullopt);
  }
  return line;
}

/// All states at once by least squares of start, pushes and measurements, each whitened.
struct Batch {
  VectorXd states;
  MatrixXd covariance;
};

Batch batch_of(const Line& line) {
  const auto seconds = static_cast<Eigen::Index>(line.places.size());
  MatrixXd a = MatrixXd::Zero(2 + 3 * seconds, 2 + 2 * seconds);
  VectorXd b = VectorXd::Zero(a.rows());
  const Matrix2d l_start = base::cholesky(line.start_covariance);
  const Matrix2d l_push = base::cholesky(line.q);
  a.block<2, 2>(0, 0) = base::solve_lower(MatrixXd(l_start), MatrixXd(Matrix2d::Identity()));
  b.head<2>() = base::solve_lower(MatrixXd(l_start), VectorXd(line.start));
  for (Eigen::Index k = 0; k < seconds; ++k) {
    const Eigen::Index row = 2 + 3 * k;
    a.block<2, 2>(row, 2 * k) = -base::solve_lower(MatrixXd(l_push), MatrixXd(line.phi));
    a.block<2, 2>(row, 2 * k + 2) = base::solve_lower(MatrixXd(l_push), MatrixXd(Matrix2d::Identity()));
    if (!line.places[static_cast<std::size_t>(k)]) continue;
    a(row + 2, 2 * k + 2) = 1.0 / std::sqrt(line.variance);
    b(row + 2) = *line.places[static_cast<std::size_t>(k)] / std::sqrt(line.variance);
  }
  const MatrixXd information = a.transpose() * a;
  return {base::solve_pivoted_qr(a, b), base::solve_llt(information, MatrixXd(MatrixXd::Identity(a.cols(), a.cols())))};
}

TEST(Smoother, OfALineIsLeastSquaresOfTheWholeWay) {
  const Line line = pushed_line();
  std::vector<FilterInterval> intervals;
  std::vector<Vector2d> estimates = {line.start};
  Matrix2d p = line.start_covariance;
  for (const std::optional<double>& place : line.places) {
    Vector2d x = line.phi * estimates.back();
    const Matrix2d end = line.phi * p * line.phi.transpose() + line.q;
    Vector2d fed_back = Vector2d::Zero();
    MatrixXd begin = p;
    p = end;
    if (place) {
      const Vector2d k = end.col(0) / (end(0, 0) + line.variance);
      fed_back = k * (x(0) - *place);
      p = end - k * end.row(0);
    }
    x -= fed_back;
    intervals.push_back({begin, line.phi, end, fed_back});
    estimates.push_back(x);
  }
  const auto left = left_errors(intervals, p);
  const Batch batch = batch_of(line);
  ASSERT_EQ(left.size(), estimates.size());
  for (std::size_t k = 0; k < left.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(2 * k);
    EXPECT_LT((estimates[k] - left[k].errors - batch.states.segment<2>(row)).norm(), 1e-9) << k;
    EXPECT_LT((left[k].covariance - batch.covariance.block<2, 2>(row, row)).norm(), 1e-9) << k;
  }
}

TEST(Smoother, LeavesAStateAloneThatIsKnownExactly) {
  const MatrixXd known = Vector2d(1.0, 0.0).asDiagonal();
  const MatrixXd after = Vector2d(0.5, 0.0).asDiagonal();
  const FilterInterval interval{known, MatrixXd::Identity(2, 2), known, Vector2d(0.2, 0.0)};
  const auto left = left_errors(std::vector{interval}, after);
  EXPECT_LT((left[0].errors - Vector2d(0.2, 0.0)).norm(), 1e-15);
  EXPECT_LT((left[0].covariance - after).norm(), 1e-15);
}

/// Errors of the filter and of the smoother at the same times of a drive.
struct Compared {
  std::vector<VectorXd> filtered, smoothed;
  std::vector<MatrixXd> filtered_covariance, smoothed_covariance;
  std::vector<double> antenna_nees;  ///< of the smoother's antenna: 3 degrees of freedom
};

Compared compared(const Simulated& made, const FilterOptions& options, const std::vector<double>& t_s) {
  Compared both;
  FilterRun run(made.drive, made.start, options);
  const auto points = smoothed(made.drive, made.start, options, t_s);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    run.advance_to(t_s[i]);
    const TruthPoint& truth = made.drive.truth[static_cast<std::size_t>(std::lround(t_s[i] * 5.0))];
    const ImuSample& sample = made.truth_imu[static_cast<std::size_t>(std::lround(t_s[i] * 50.0)) - 1];
    both.filtered.push_back(errors_of(run.filter().state(), truth, sample));
    both.smoothed.push_back(errors_of(points[i].state, truth, sample));
    both.filtered_covariance.push_back(run.filter().covariance());
    both.smoothed_covariance.push_back(points[i].covariance);
    const VectorXd antenna_m = offset_m(truth.position, points[i].antenna);
    both.antenna_nees.push_back(antenna_m.dot(base::solve_llt(MatrixXd(points[i].antenna_covariance_m2), antenna_m)));
  }
  return both;
}

std::vector<double> every_five_seconds() {
  std::vector<double> t_s;
  for (int t = 5; t < kSeconds; t += 5) t_s.push_back(t);
  return t_s;
}

double squares(const std::vector<VectorXd>& errors, int from) {
  double sum = 0.0;
  for (const VectorXd& error : errors) sum += error.segment<3>(from).squaredNorm();
  return sum;
}

TEST(Smoother, KnowsHowWrongItIsAndIsLessWrongThanTheFilter) {
  SOAK_LONG_TEST();
  constexpr int kRuns = 100;
  std::vector<std::vector<double>> of_runs, of_antenna;
  double filtered[3] = {};
  double smoothed[3] = {};
  for (int number = 0; number < kRuns; ++number) {
    const Compared both = compared(simulated(number, false), matching(false), every_five_seconds());
    of_antenna.push_back(both.antenna_nees);
    auto& of_run = of_runs.emplace_back();
    for (std::size_t i = 0; i < both.smoothed.size(); ++i) {
      of_run.push_back(nees(both.smoothed[i], both.smoothed_covariance[i]));
    }
    for (int part = 0; part < 3; ++part) {
      filtered[part] += squares(both.filtered, 3 * part);
      smoothed[part] += squares(both.smoothed, 3 * part);
    }
  }
  // As for the filter: 95 % of the epochs of a drive, which depend on each other; here of 11.
  EXPECT_GE(share_within(of_runs, 9), 8.0 / 11.0);
  EXPECT_GE(share_within(of_antenna, 3), 8.0 / 11.0);
  for (int part = 0; part < 3; ++part) EXPECT_LT(smoothed[part], 0.8 * filtered[part]) << part;
}

/// The largest difference of two covariances, each state by its own size.
double largest_difference(const MatrixXd& a, const MatrixXd& b) {
  const VectorXd size = a.diagonal().cwiseSqrt().cwiseInverse();
  return MatrixXd(size.asDiagonal() * (a - b) * size.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(Smoother, LearnsAsMuchFromAFixThatMeetsTheEstimateExactly) {
  Simulated made = simulated(3, false);
  made.drive.gnss = {made.drive.gnss[20]};
  GnssFix& fix = made.drive.gnss.front();
  FilterRun run(made.drive, made.start, matching(false));
  run.lose_fixes();
  run.advance_to(fix.t_s);
  fix.position = run.filter().antenna();
  fix.velocity_mps = run.filter().antenna_velocity_mps();
  const std::vector<double> t_s = {fix.t_s - 5.0, fix.t_s + 5.0};
  const auto exact = smoothed(made.drive, made.start, matching(false), t_s);
  fix.velocity_mps.x() += 1e-9;
  const auto beside = smoothed(made.drive, made.start, matching(false), t_s);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    EXPECT_LT(largest_difference(exact[i].covariance, beside[i].covariance), 1e-6) << t_s[i];
  }
}

TEST(Smoother, NeverKnowsLessThanTheFilter) {
  FilterOptions options = matching(true);
  options.non_holonomic = NonHolonomic{};
  for (int number = 0; number < 5; ++number) {
    const Compared both = compared(simulated(number, true), options, every_five_seconds());
    for (std::size_t i = 0; i < both.smoothed.size(); ++i) {
      // Each state by its own size, that rounding of the largest hides none.
      const VectorXd size = both.filtered_covariance[i].diagonal().cwiseSqrt().cwiseInverse();
      const MatrixXd gained = both.filtered_covariance[i] - both.smoothed_covariance[i];
      const auto gains = base::symmetric_eigen(MatrixXd(size.asDiagonal() * gained * size.asDiagonal()));
      EXPECT_GT(gains.values.minCoeff(), -1e-9) << number << ", " << i;
      EXPECT_GT(base::symmetric_eigen(both.smoothed_covariance[i]).values.minCoeff(), 0.0);
    }
  }
}

TEST(Smoother, BridgesAnOutageFromBothSides) {
  const std::vector<double> outage_s = {25.0, 30.0, 35.0, 39.8};
  double filtered[4] = {};
  double smoothed[4] = {};
  for (int number = 0; number < 20; ++number) {
    Simulated made = simulated(number, false);
    std::erase_if(made.drive.gnss, [](const GnssFix& fix) { return fix.t_s > 20.5 && fix.t_s < 39.9; });
    const Compared both = compared(made, matching(false), outage_s);
    for (std::size_t i = 0; i < outage_s.size(); ++i) {
      filtered[i] += both.filtered[i].head<2>().squaredNorm();
      smoothed[i] += both.smoothed[i].head<2>().squaredNorm();
    }
  }
  // The worst of the filter is the end; the smoother knows where the outage ended and is worst in its middle.
  EXPECT_LT(smoothed[3], 0.05 * filtered[3]);
  EXPECT_LT(smoothed[3], smoothed[1]);
  for (int i = 0; i < 4; ++i) EXPECT_LT(smoothed[i], filtered[i]) << outage_s[static_cast<std::size_t>(i)];
}

}  // namespace
}  // namespace soak::nav
