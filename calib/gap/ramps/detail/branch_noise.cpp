// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/branch_noise.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "calib/gap/ramps/detail/ramp_spline.h"

namespace soak::calib::gap::reduced {
namespace {

constexpr std::array kIntervals = {2, 3, 4, 5, 6, 8, 10};
constexpr Eigen::Index kLeastRows = 8;
constexpr double kMostCorrelation = 0.9;

/// What is left of the branches about their own curves.
struct Remainder {
  double squares = 0.0;
  double neighbours = 0.0;  ///< sum of the products of neighbouring residuals
  double rows = 0.0;
  double parameters = 0.0;
};

void add_branch(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, int intervals, Remainder& total) {
  const Eigen::Index rows = values.size();
  if (rows < kLeastRows) return;
  // Two rows for each column at least.
  const int most = std::max(1, static_cast<int>(rows / 2) - 3);
  const Eigen::MatrixXd basis =
      ramp_spline(temp_c, temp_c.minCoeff(), temp_c.maxCoeff(), std::clamp(intervals, 1, most));
  const Eigen::VectorXd left = values - basis * basis.completeOrthogonalDecomposition().solve(values);
  total.squares += left.squaredNorm();
  total.neighbours += left.head(rows - 1).dot(left.tail(rows - 1));
  total.rows += static_cast<double>(rows);
  total.parameters += static_cast<double>(basis.cols());
}

Remainder remainder_of(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, const std::vector<int>& branch,
                       int intervals) {
  const double range_c = temp_c.maxCoeff() - temp_c.minCoeff();
  Remainder total;
  Eigen::Index first = 0;
  for (Eigen::Index i = 1; i <= values.size(); ++i) {
    if (i < values.size() && branch[static_cast<std::size_t>(i)] == branch[static_cast<std::size_t>(first)]) continue;
    const Eigen::VectorXd own_c = temp_c.segment(first, i - first);
    const double share = (own_c.maxCoeff() - own_c.minCoeff()) / range_c;
    if (share > 0.0) {
      add_branch(values.segment(first, i - first), own_c, static_cast<int>(std::lround(intervals * share)), total);
    }
    first = i;
  }
  return total;
}

}  // namespace

BranchNoise branch_noise(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, const std::vector<int>& branch) {
  BranchNoise best;
  double least = std::numeric_limits<double>::infinity();
  for (const int intervals : kIntervals) {
    const Remainder left = remainder_of(values, temp_c, branch, intervals);
    if (left.rows <= left.parameters || left.squares <= 0.0) continue;
    const double criterion = left.rows * std::log(left.squares / left.rows) + left.parameters * std::log(left.rows);
    if (criterion >= least) continue;
    least = criterion;
    best.intervals = intervals;
    best.sigma = std::sqrt(left.squares / (left.rows - left.parameters));
    // A fit of p parameters to n rows makes neighbours look opposite by about p/n.
    best.correlation = std::clamp(left.neighbours / left.squares + left.parameters / left.rows, 0.0, kMostCorrelation);
  }
  return best;
}

}  // namespace soak::calib::gap::reduced
