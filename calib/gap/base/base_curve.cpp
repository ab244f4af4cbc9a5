// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/base_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "base/linear/dense_solve.h"

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
  return base::solve_lu(left, right);
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

bool with_scale(const Observations& observations, Sensor sensor) {
  return !is_gyro(sensor) && observations.has_positions();
}

double off_level(const Observations& observations, const Observation& row, double temp_c) {
  return temp_c - observations.level_c[static_cast<std::size_t>(row.level)];
}

}  // namespace

LevelSpline::LevelSpline(std::vector<double> knots) : knots_(std::move(knots)), second_(second_derivatives(knots_)) {}

Eigen::RowVectorXd LevelSpline::weights(double x) const { return weights(std::vector{x}); }

/// Knot by knot, so that the columns of the result are written from end to end.
Eigen::MatrixXd LevelSpline::weights(const std::vector<double>& x) const {
  const auto n = static_cast<Eigen::Index>(x.size());
  const auto count = static_cast<Eigen::Index>(knots_.size());
  if (count == 1) return Eigen::MatrixXd::Ones(n, 1);
  std::vector<Place> places;
  places.reserve(x.size());
  for (const double one : x) places.push_back(place_of(knots_, one));
  Eigen::MatrixXd result(n, count);
  for (Eigen::Index knot = 0; knot < count; ++knot) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& [k, inside, h, a, b] = places[static_cast<std::size_t>(i)];
      result(i, knot) = h * h / 6.0 * ((a * a * a - a) * second_(k, knot) + (b * b * b - b) * second_(k + 1, knot));
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& [k, inside, h, a, b] = places[static_cast<std::size_t>(i)];
    const double beyond = x[static_cast<std::size_t>(i)] - inside;
    result(i, k) += a;
    result(i, k + 1) += b;
    if (beyond != 0.0) result.row(i) += beyond * slope_weights(inside);
  }
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

BaseDesign base_design(const Observations& observations, Sensor sensor, const std::vector<double>& temp_c) {
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  const Eigen::Index levels = observations.level_count();
  const Eigen::Index offsets = observations.run_count() - 1;
  const bool scale = with_scale(observations, sensor);
  const Eigen::MatrixXd weights = LevelSpline(observations.level_c).weights(temp_c);
  BaseDesign design;
  design.levels = levels;
  design.offsets = offsets;
  design.columns = Eigen::MatrixXd::Zero(n, 2 * levels + (scale ? levels + 2 : 0) + offsets);
  const Eigen::Index first_offset = design.columns.cols() - offsets;
  const std::size_t axis = axis_of(sensor);
  design.columns.leftCols(levels) = weights;
  Eigen::VectorXd force_g(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    design.columns(i, levels + row.level) = off_level(observations, row, temp_c[static_cast<std::size_t>(i)]);
    if (scale) {
      force_g(i) = observations.force_g(row, axis);
      design.columns(i, 3 * levels) = observations.force_g(row, (axis + 1) % 3);
      design.columns(i, 3 * levels + 1) = observations.force_g(row, (axis + 2) % 3);
    }
    if (row.run > 0) design.columns(i, first_offset + row.run - 1) = 1.0;
  }
  if (scale) design.columns.middleCols(2 * levels, levels) = force_g.asDiagonal() * weights;
  return design;
}

Eigen::VectorXd slope_sigmas(const std::vector<double>& level_c, const Eigen::VectorXd& levels) {
  const Eigen::Index count = levels.size();
  if (count < 2) return Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  const double spacing_c = (level_c.back() - level_c.front()) / static_cast<double>(count - 1);
  if (count == 2) return Eigen::VectorXd::Constant(2, std::abs(levels(1) - levels(0)) / spacing_c);
  double largest = 0.0;
  for (Eigen::Index k = 1; k + 1 < count; ++k) {
    std::vector<double> others = level_c;
    others.erase(others.begin() + k);
    Eigen::VectorXd values(count - 1);
    values << levels.head(k), levels.tail(count - 1 - k);
    const double off = levels(k) - LevelSpline(others).weights(level_c[static_cast<std::size_t>(k)]).dot(values);
    largest = std::max(largest, std::abs(off));
  }
  constexpr double kNaturalEnd = 0.3;
  const auto at_end = [&](Eigen::Index end, Eigen::Index inwards) {
    const double second = levels(end) - 2.0 * levels(end + inwards) + levels(end + 2 * inwards);
    return std::max(largest, kNaturalEnd * std::abs(second));
  };
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(count, largest);
  sigmas(0) = at_end(0, 1);
  sigmas(count - 1) = at_end(count - 1, -1);
  return sigmas / spacing_c;
}

Eigen::VectorXd base_slope(const Observations& observations, Sensor sensor, const std::vector<double>& temp_c,
                           const Eigen::VectorXd& coefficients) {
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  const Eigen::Index levels = observations.level_count();
  const bool scale = with_scale(observations, sensor);
  const LevelSpline spline(observations.level_c);
  Eigen::VectorXd slope(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd weights = spline.slope_weights(temp_c[static_cast<std::size_t>(i)]);
    slope(i) = weights.dot(coefficients.head(levels)) + coefficients(levels + row.level);
    if (scale) {
      slope(i) += observations.force_g(row, axis_of(sensor)) * weights.dot(coefficients.segment(2 * levels, levels));
    }
  }
  return slope;
}

}  // namespace soak::calib::gap
