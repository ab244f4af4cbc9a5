// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace soak::calib::gap {

/// How well a curve that is smooth but for one feature explains what levels read.
struct FeatureFit {
  double log_likelihood = 0.0;  ///< restricted, at the best scale; of features of one curve comparable with each other
  double height = 0.0;          ///< factor of the shape
  /// Squared height over its variance, which holds the levels' own covariance and how far a curve of this scale strays
  /// between its levels.
  double squared_ratio = 0.0;
  double length_c = 0.0;  ///< correlation length of the rest of the curve
};

/// A thermal curve that is known at some levels and taken for smooth: a Gaussian process about a straight line,
///   cov(f(T), f(T′)) = a² exp(−(T − T′)²/2ℓ²),   level = f(T) + an error of the covariance given.
/// Nothing is assumed of a and ℓ: the levels tell them, by restricted likelihood over a grid (ℓ from 0.7 of the typical
/// distance of levels to their range, a from 0.006 to 4 times their span), so that what a rough curve does between its
/// levels is not taken for a feature of it [Rasmussen and Williams 2006, eq. 2.30, 5.8].
class SmoothCurve {
 public:
  /// At least six levels, rising; `covariance` of their errors, positive semidefinite. O(80 n³).
  SmoothCurve(const std::vector<double>& level_c, const Eigen::VectorXd& levels, const Eigen::MatrixXd& covariance);

  /// Each column of `shapes` (one row per level) in turn beside the smooth curve, each with the scale that is best with
  /// it: with that of the whole a large feature would be taken for roughness. A column that is straight in temperature
  /// has height and squared ratio 0. O(80 n²) per column.
  [[nodiscard]] std::vector<FeatureFit> with_each(const Eigen::MatrixXd& shapes) const;

 private:
  /// The levels under one scale, whitened and freed of the straight line.
  struct Scale {
    double length_c;
    Eigen::MatrixXd factor;  ///< Cholesky's, of the levels' covariance
    Eigen::MatrixXd line;    ///< orthonormal, spans the whitened straight lines
    Eigen::VectorXd residual;
    double log_likelihood;
  };
  std::vector<Scale> scales_;
};

}  // namespace soak::calib::gap
