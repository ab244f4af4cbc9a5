// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/whitened_base.h"

#include <cmath>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/linear/products.h"

namespace soak::calib::gap {
namespace {

constexpr double kRankTolerance = 1e-9;
/// The reciprocal of the largest condition of columns of unit length at which the normal equations, where it is
/// squared, lose no more than half of the digits.
constexpr double kIndependent = 1e-4;

}  // namespace

WhitenedBase::WhitenedBase(const Whitening& whitening, const Eigen::MatrixXd& base, const Eigen::VectorXd& readings)
    : columns_(whitening.apply(base)),
      readings_(whitening.apply(readings)),
      products_(base::lower_products(columns_)) {}

/// By normal equations with one step of refinement, where no columns depend on each other but for columns of zeros (the
/// offset of a run that is left out); nothing where some nearly do.
std::optional<anfis::LeastSquaresFit> WhitenedBase::solve_independent(const Eigen::VectorXd& prior) const {
  // The columns of [X; P] with P = diag(prior) get unit length: U = [X; P] D.
  const Eigen::VectorXd norm = (products_.diagonal() + prior.cwiseAbs2()).cwiseSqrt();
  if (norm.size() == 0 || !norm.allFinite() || !readings_.allFinite()) return std::nullopt;
  const Eigen::VectorXd scale = (norm.array() > 0.0).select(norm.cwiseInverse(), 0.0);
  const Eigen::VectorXd empty = (norm.array() > 0.0).select(Eigen::VectorXd::Zero(norm.size()), 1.0);
  Eigen::MatrixXd unit_products = products_;  // UᵀU
  unit_products.diagonal() += prior.cwiseAbs2();
  unit_products = scale.asDiagonal() * unit_products * scale.asDiagonal();
  unit_products.diagonal() += empty;
  const std::optional<Eigen::MatrixXd> lower = base::try_cholesky(unit_products);
  if (!lower) return std::nullopt;
  const Eigen::MatrixXd present = (1.0 - empty.array()).matrix().asDiagonal();
  const Eigen::MatrixXd factor = base::solve_lower(*lower, present).transpose();  // F Fᵀ = (UᵀU)⁺
  // The condition is at most the product of the norms of both, and that of unit columns is the root of their number.
  if (factor.norm() * std::sqrt(static_cast<double>(norm.size())) * kIndependent > 1.0) return std::nullopt;
  const auto solved = [&](const Eigen::VectorXd& of_columns) -> Eigen::VectorXd {
    return scale.asDiagonal() * (factor * (factor.transpose() * (scale.asDiagonal() * of_columns)));
  };
  anfis::LeastSquaresFit fit;
  fit.coefficients = solved(columns_.transpose() * readings_);
  const Eigen::VectorXd left = readings_ - columns_ * fit.coefficients;
  fit.coefficients += solved(columns_.transpose() * left - prior.cwiseAbs2().cwiseProduct(fit.coefficients));
  fit.covariance_factor = scale.asDiagonal() * factor;
  return fit;
}

anfis::LeastSquaresFit WhitenedBase::solve(const Eigen::VectorXd& prior) const {
  if (auto fit = solve_independent(prior)) return *std::move(fit);
  const Eigen::Index rows = columns_.rows();
  Eigen::MatrixXd columns(rows + prior.size(), prior.size());
  columns.topRows(rows) = columns_;
  columns.bottomRows(prior.size()) = prior.asDiagonal();
  Eigen::VectorXd readings = Eigen::VectorXd::Zero(rows + prior.size());
  readings.head(rows) = readings_;
  return anfis::solve_least_squares(columns, readings, kRankTolerance);
}

}  // namespace soak::calib::gap
