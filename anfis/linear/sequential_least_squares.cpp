// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/sequential_least_squares.h"

#include <cassert>
#include <cmath>

namespace soak::anfis {

SequentialLeastSquares::SequentialLeastSquares(std::size_t columns, double initial_covariance, double forgetting)
    : initial_covariance_(initial_covariance),
      forgetting_(forgetting),
      coefficients_(static_cast<Eigen::Index>(columns)),
      covariance_(coefficients_.size(), coefficients_.size()),
      direction_(coefficients_.size()),
      next_(coefficients_.size()) {
  assert(columns >= 1 && initial_covariance > 0.0 && forgetting > 0.0 && forgetting <= 1.0);
  restart();
}

bool SequentialLeastSquares::update(const Eigen::Ref<const Eigen::VectorXd>& a, double b) {
  assert(a.size() == coefficients_.size());
  direction_.noalias() = covariance_ * a;
  const double variance = a.dot(direction_);
  // [AH05 eq. 5.14] X + S_{i+1} a (b - a^T X), where S_{i+1} a = S_i a / (lambda + a^T S_i a)
  next_ = coefficients_ + direction_ * ((b - a.dot(coefficients_)) / (forgetting_ + variance));
  if (!next_.allFinite() || !std::isfinite(variance) || !std::isfinite(direction_.squaredNorm())) return false;
  coefficients_.swap(next_);
  // [AH05 eq. 5.14] (S - S a a^T S / (lambda + a^T S a)) / lambda
  subtract(1.0 / (forgetting_ + variance));
  if (forgetting_ < 1.0) {
    covariance_ /= forgetting_;
    limit_covariance();
  }
  return true;
}

void SequentialLeastSquares::restart() {
  coefficients_.setZero();
  restart_covariance();
}

void SequentialLeastSquares::restart(const Eigen::Ref<const Eigen::VectorXd>& coefficients) {
  assert(coefficients.size() == coefficients_.size());
  coefficients_ = coefficients;
  restart_covariance();
}

void SequentialLeastSquares::restart_covariance() {
  covariance_.setZero();
  covariance_.diagonal().setConstant(initial_covariance_);
}

void SequentialLeastSquares::limit_covariance() {
  for (Eigen::Index j = 0; j < covariance_.cols(); ++j) {
    const double variance = covariance_(j, j);
    if (variance <= 2.0 * initial_covariance_) continue;
    // S - S e_j e_j^T S (1 - eta / S_jj) / S_jj
    direction_ = covariance_.col(j);
    subtract((1.0 - initial_covariance_ / variance) / variance);
  }
}

/// S <- S - share direction_ direction_^T, one triangle mirrored to the other.
void SequentialLeastSquares::subtract(double share) {
  for (Eigen::Index column = 0; column < covariance_.cols(); ++column) {
    const double scaled = share * direction_(column);
    for (Eigen::Index row = column; row < covariance_.rows(); ++row) {
      covariance_(row, column) -= direction_(row) * scaled;
      covariance_(column, row) = covariance_(row, column);
    }
  }
}

}  // namespace soak::anfis
