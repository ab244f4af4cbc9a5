// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/smooth_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kShortest = 0.7;  ///< length over the typical distance of the levels
constexpr double kLengthStep = 1.4142135623730951;
constexpr double kLeastAmplitude = 0.006;  ///< over the span of the levels
constexpr double kMostAmplitude = 4.0;
constexpr double kAmplitudeStep = 2.5;
/// Added to the diagonal, over a²: long lengths leave a matrix that is singular to the machine.
constexpr double kJitter = 1e-10;
/// Shapes of which the straight line leaves less than this share of their squares are none.
constexpr double kStraight = 1e-9;

double typical_distance(const std::vector<double>& level_c) {
  std::vector<double> distances;
  for (std::size_t k = 1; k < level_c.size(); ++k) distances.push_back(level_c[k] - level_c[k - 1]);
  return base::median(distances);
}

Eigen::MatrixXd correlation(const std::vector<double>& level_c, double length_c) {
  const auto n = static_cast<Eigen::Index>(level_c.size());
  Eigen::MatrixXd result(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const double off = (level_c[static_cast<std::size_t>(i)] - level_c[static_cast<std::size_t>(j)]) / length_c;
      result(i, j) = std::exp(-0.5 * off * off);
    }
  }
  return result;
}

/// Columns 1 and T, scaled to be of one size.
Eigen::MatrixXd straight_lines(const std::vector<double>& level_c) {
  const auto n = static_cast<Eigen::Index>(level_c.size());
  const double middle_c = 0.5 * (level_c.front() + level_c.back());
  Eigen::MatrixXd lines(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    lines(i, 0) = 1.0;
    lines(i, 1) = (level_c[static_cast<std::size_t>(i)] - middle_c) / (level_c.back() - middle_c);
  }
  return lines;
}

void remove_part_along(const Eigen::MatrixXd& orthonormal, Eigen::MatrixXd& columns) {
  columns -= orthonormal * (orthonormal.transpose() * columns);
}

}  // namespace

SmoothCurve::SmoothCurve(const std::vector<double>& level_c, const Eigen::VectorXd& levels,
                         const Eigen::MatrixXd& covariance) {
  const auto n = levels.size();
  const double span = levels.maxCoeff() - levels.minCoeff();
  if (!(span > 0.0)) return;  // a constant without scatter
  const double range_c = level_c.back() - level_c.front();
  const Eigen::MatrixXd lines = straight_lines(level_c);
  for (double length_c = kShortest * typical_distance(level_c); length_c <= range_c; length_c *= kLengthStep) {
    const Eigen::MatrixXd unit = correlation(level_c, length_c) + kJitter * Eigen::MatrixXd::Identity(n, n);
    for (double a = kLeastAmplitude * span; a <= kMostAmplitude * span; a *= kAmplitudeStep) {
      const std::optional<Eigen::MatrixXd> factor = base::try_cholesky(a * a * unit + covariance);
      if (!factor) continue;
      Scale scale{length_c, *factor, base::solve_lower(*factor, lines), base::solve_lower(*factor, levels), 0.0};
      // HᵀK⁻¹H = R Rᵀ: its determinant belongs to the restricted likelihood, and H R⁻ᵀ is orthonormal.
      const Eigen::MatrixXd root = base::cholesky(Eigen::MatrixXd(scale.line.transpose() * scale.line));
      scale.line = base::solve_lower(root, Eigen::MatrixXd(scale.line.transpose())).transpose();
      scale.residual -= scale.line * (scale.line.transpose() * scale.residual);
      // −½ (ln|K| + ln|HᵀK⁻¹H| + rᵀr)
      scale.log_likelihood = -factor->diagonal().array().log().sum() - root.diagonal().array().log().sum() -
                             0.5 * scale.residual.squaredNorm();
      scales_.push_back(std::move(scale));
    }
  }
}

std::vector<FeatureFit> SmoothCurve::with_each(const Eigen::MatrixXd& shapes) const {
  std::vector<FeatureFit> fits(static_cast<std::size_t>(shapes.cols()));
  for (FeatureFit& fit : fits) fit.log_likelihood = -std::numeric_limits<double>::infinity();
  for (const Scale& scale : scales_) {
    Eigen::MatrixXd white = base::solve_lower(scale.factor, shapes);
    const Eigen::RowVectorXd before = white.colwise().squaredNorm();
    remove_part_along(scale.line, white);
    const Eigen::RowVectorXd information = white.colwise().squaredNorm();
    const Eigen::RowVectorXd score = scale.residual.transpose() * white;
    for (Eigen::Index c = 0; c < shapes.cols(); ++c) {
      const bool shows = information(c) > kStraight * before(c);
      const double ratio = shows ? score(c) * score(c) / information(c) : 0.0;
      FeatureFit& fit = fits[static_cast<std::size_t>(c)];
      if (scale.log_likelihood + 0.5 * ratio <= fit.log_likelihood) continue;
      fit = {scale.log_likelihood + 0.5 * ratio, shows ? score(c) / information(c) : 0.0, ratio, scale.length_c};
    }
  }
  return fits;
}

}  // namespace soak::calib::gap
