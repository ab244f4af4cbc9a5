// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base_curve/level_spline.h"

#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <utility>

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

/// Where a temperature lies among the knots.
struct Place {
  Eigen::Index piece = 0;
  double inside = 0.0;  ///< the temperature, clamped to the knots
  double h = 1.0;       ///< length of the piece
  double a = 1.0;       ///< weight of its lower knot
  double b = 0.0;       ///< weight of its upper knot
};

Place place_of(const std::vector<double>& knots, double x) {
  Place place;
  place.inside = std::clamp(x, knots.front(), knots.back());
  place.piece = std::upper_bound(knots.begin() + 1, knots.end() - 1, place.inside) - knots.begin() - 1;
  const double low = knots[static_cast<std::size_t>(place.piece)];
  place.h = knots[static_cast<std::size_t>(place.piece) + 1] - low;
  place.b = (place.inside - low) / place.h;
  place.a = 1.0 - place.b;
  return place;
}

}  // namespace

LevelSpline::LevelSpline(std::vector<double> knots) : knots_(std::move(knots)), second_(second_derivatives(knots_)) {}

Eigen::RowVectorXd LevelSpline::weights(double x) const {
  if (knots_.size() == 1) return Eigen::RowVectorXd::Ones(1);
  const auto [k, inside, h, a, b] = place_of(knots_, x);
  Eigen::RowVectorXd result = h * h / 6.0 * ((a * a * a - a) * second_.row(k) + (b * b * b - b) * second_.row(k + 1));
  result(k) += a;
  result(k + 1) += b;
  if (inside != x) result += (x - inside) * slope_weights(inside);
  return result;
}

Eigen::RowVectorXd LevelSpline::slope_weights(double x) const {
  if (knots_.size() == 1) return Eigen::RowVectorXd::Zero(1);
  const auto [k, inside, h, a, b] = place_of(knots_, x);
  Eigen::RowVectorXd result =
      h / 6.0 * ((1.0 - 3.0 * a * a) * second_.row(k) + (3.0 * b * b - 1.0) * second_.row(k + 1));
  result(k) -= 1.0 / h;
  result(k + 1) += 1.0 / h;
  return result;
}

}  // namespace soak::calib::gap
