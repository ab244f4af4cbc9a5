// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/session_wander.h"

#include <algorithm>
#include <cmath>

#include "base/linear/dense_solve.h"

namespace soak::calib::six_position {
namespace {

constexpr Eigen::Index kLeastSpare = 4;  ///< rows beside the unknowns
constexpr double kDependent = 1e-9;      ///< pivots below count as zero, relative

/// What is left of the readings and of the walk once the unknowns have taken theirs, in directions in which the walk's
/// covariance is diagonal and the noise has variance 1. Empty where too little is left.
struct Contrasts {
  Eigen::ArrayXd walk;  ///< variance of the walk of unit variance
  Eigen::ArrayXd read;
};

/// An orthonormal basis of what is orthogonal to the columns.
Eigen::MatrixXd complement_of(const Eigen::MatrixXd& columns) {
  const auto n = columns.rows();
  const auto projection =
      base::solve_orthogonal_with_factor(columns, Eigen::VectorXd(Eigen::VectorXd::Zero(n)), kDependent);
  const Eigen::MatrixXd spanning = columns * projection.factor;
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n) - spanning * spanning.transpose();
  const base::SymmetricEigen eigen = base::symmetric_eigen(rest);
  return eigen.vectors.rightCols(n - projection.rank);
}

Contrasts contrasts_of(const Eigen::MatrixXd& design, const Eigen::VectorXd& y, const Eigen::VectorXd& noise,
                       const Eigen::VectorXd& tau) {
  const Eigen::VectorXd root = noise.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd free = complement_of(root.asDiagonal() * design);
  if (free.cols() < kLeastSpare) return {};
  const Eigen::MatrixXd seen = root.asDiagonal() * free;
  const Eigen::MatrixXd walk = seen.transpose() * walk_about_its_mean(tau) * seen;
  const base::SymmetricEigen eigen = base::symmetric_eigen(walk);
  return {eigen.values.array().max(0.0), (eigen.vectors.transpose() * (seen.transpose() * y)).array()};
}

double log_likelihood(const Contrasts& contrasts, double variance) {
  const Eigen::ArrayXd total = 1.0 + variance * contrasts.walk;
  return -0.5 * (total.log() + contrasts.read.square() / total).sum();
}

}  // namespace

Eigen::MatrixXd walk_about_its_mean(const Eigen::VectorXd& tau) {
  const double start = tau.minCoeff();
  const double length = tau.maxCoeff() - start;
  Eigen::MatrixXd covariance(tau.size(), tau.size());
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    for (Eigen::Index j = 0; j < tau.size(); ++j) {
      const double s = (tau[i] - start) / length;
      const double t = (tau[j] - start) / length;
      covariance(i, j) = 1.0 / 3.0 - std::max(s, t) + 0.5 * (s * s + t * t);
    }
  }
  return covariance;
}

SessionWander estimate_session_wander(const Eigen::MatrixXd& design, const Eigen::VectorXd& y,
                                      const Eigen::VectorXd& noise, const Eigen::VectorXd& tau) {
  SessionWander wander;
  if (!(tau.maxCoeff() > tau.minCoeff())) return wander;
  const Contrasts contrasts = contrasts_of(design, y, noise, tau);
  if (contrasts.walk.size() == 0 || !(contrasts.walk.maxCoeff() > 0.0)) return wander;
  // From a hundredth of the noise to a million times of it, in steps of a quarter: finer than any session can tell.
  double best = log_likelihood(contrasts, 0.0);
  for (int step = -20; step <= 60; ++step) {
    const double variance = std::pow(10.0, 0.1 * step) / contrasts.walk.maxCoeff();
    const double likelihood = log_likelihood(contrasts, variance);
    if (likelihood <= best) continue;
    best = likelihood;
    wander.variance = variance;
  }
  wander.information = 0.5 * (contrasts.walk / (1.0 + wander.variance * contrasts.walk)).square().sum();
  return wander;
}

}  // namespace soak::calib::six_position
