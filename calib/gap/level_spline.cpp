// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/level_spline.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace soak::calib::gap {
namespace {

/// Second derivatives at the knots of the natural spline through unit vectors.
Eigen::MatrixXd second_derivatives(const std::vector<double>& knots) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, n);
  const auto h = [&](Eigen::Index k) {
    return knots[static_cast<std::size_t>(k) + 1] - knots[static_cast<std::size_t>(k)];
  };
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    left(k, k - 1) = h(k - 1) / 6.0;
    left(k, k) = (h(k - 1) + h(k)) / 3.0;
    left(k, k + 1) = h(k) / 6.0;
    right(k, k - 1) = 1.0 / h(k - 1);
    right(k, k) = -1.0 / h(k - 1) - 1.0 / h(k);
    right(k, k + 1) = 1.0 / h(k);
  }
  return left.partialPivLu().solve(right);
}

}  // namespace

LevelSpline::LevelSpline(std::vector<double> knots) : knots_(std::move(knots)), second_(second_derivatives(knots_)) {}

Eigen::RowVectorXd LevelSpline::weights(double x) const {
  const auto n = static_cast<Eigen::Index>(knots_.size());
  if (n == 1) return Eigen::RowVectorXd::Ones(1);
  const double inside = std::clamp(x, knots_.front(), knots_.back());
  const auto upper = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, inside);
  const Eigen::Index k = upper - knots_.begin() - 1;
  const double low = knots_[static_cast<std::size_t>(k)];
  const double h = knots_[static_cast<std::size_t>(k) + 1] - low;
  const double b = (inside - low) / h;
  const double a = 1.0 - b;
  Eigen::RowVectorXd result = h * h / 6.0 * ((a * a * a - a) * second_.row(k) + (b * b * b - b) * second_.row(k + 1));
  result(k) += a;
  result(k + 1) += b;
  if (inside != x) result += (x - inside) * slope_weights(inside);
  return result;
}

Eigen::RowVectorXd LevelSpline::slope_weights(double x) const {
  const auto n = static_cast<Eigen::Index>(knots_.size());
  if (n == 1) return Eigen::RowVectorXd::Zero(1);
  const double inside = std::clamp(x, knots_.front(), knots_.back());
  const auto upper = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, inside);
  const Eigen::Index k = upper - knots_.begin() - 1;
  const double low = knots_[static_cast<std::size_t>(k)];
  const double h = knots_[static_cast<std::size_t>(k) + 1] - low;
  const double b = (inside - low) / h;
  const double a = 1.0 - b;
  Eigen::RowVectorXd result =
      h / 6.0 * ((1.0 - 3.0 * a * a) * second_.row(k) + (3.0 * b * b - 1.0) * second_.row(k + 1));
  result(k) -= 1.0 / h;
  result(k + 1) += 1.0 / h;
  return result;
}

}  // namespace soak::calib::gap
