// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "anfis/linear/least_squares.h"
#include "calib/gap/noise/noise.h"

namespace soak::calib::gap {

/// The columns X of a base and the readings y of one sensor, made white: what a least-squares fit needs, whatever is
/// known beforehand of the coefficients.
class WhitenedBase {
 public:
  /// `base`, `readings`: one row per observation.
  WhitenedBase(const Whitening& whitening, const Eigen::MatrixXd& base, const Eigen::VectorXd& readings);

  [[nodiscard]] const Eigen::MatrixXd& columns() const { return columns_; }
  [[nodiscard]] const Eigen::VectorXd& readings() const { return readings_; }
  /// Least squares. `prior`: per column the reciprocal standard deviation that its coefficient has about 0, which is
  /// one more reading of 0; 0 = free. Columns may depend on each other.
  [[nodiscard]] anfis::LeastSquaresFit solve(const Eigen::VectorXd& prior) const;

 private:
  [[nodiscard]] std::optional<anfis::LeastSquaresFit> solve_independent(const Eigen::VectorXd& prior) const;

  Eigen::MatrixXd columns_;
  Eigen::VectorXd readings_;
  Eigen::MatrixXd products_;  ///< XᵀX, lower triangle
};

}  // namespace soak::calib::gap
