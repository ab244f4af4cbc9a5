// SPDX-License-Identifier: Apache-2.0
#include "base/linear/dense_solve.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

namespace soak::base {
namespace {

using Orthogonal = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

Orthogonal orthogonal(const Eigen::MatrixXd& a, std::optional<double> threshold) {
  Orthogonal decomposition;
  if (threshold) decomposition.setThreshold(*threshold);
  decomposition.compute(a);
  return decomposition;
}

}  // namespace

Eigen::VectorXd solve_ldlt(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return Ldlt(a).solve(b); }
Eigen::MatrixXd solve_ldlt(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return Ldlt(a).solve(b); }

struct Ldlt::Factor : Eigen::LDLT<Eigen::MatrixXd> {
  using LDLT::LDLT;
};

Ldlt::Ldlt(const Eigen::MatrixXd& a) : factor_(std::make_unique<const Factor>(a)) {}
Ldlt::Ldlt(Ldlt&&) noexcept = default;
Ldlt& Ldlt::operator=(Ldlt&&) noexcept = default;
Ldlt::~Ldlt() = default;

Eigen::VectorXd Ldlt::solve(const Eigen::VectorXd& b) const { return factor_->solve(b); }
Eigen::MatrixXd Ldlt::solve(const Eigen::MatrixXd& b) const { return factor_->solve(b); }

Eigen::VectorXd solve_llt(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.llt().solve(b); }
Eigen::MatrixXd solve_llt(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.llt().solve(b); }

Eigen::MatrixXd cholesky(const Eigen::MatrixXd& a) { return a.llt().matrixL(); }
Eigen::Matrix2d cholesky(const Eigen::Matrix2d& a) { return a.llt().matrixL(); }

std::optional<Eigen::MatrixXd> try_cholesky(const Eigen::MatrixXd& a) {
  const Eigen::LLT<Eigen::MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.matrixL();
}

Eigen::VectorXd solve_lower(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b) {
  return lower.triangularView<Eigen::Lower>().solve(b);
}

Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& b) {
  return lower.triangularView<Eigen::Lower>().solve(b);
}

// A Ref is a view, through which the matrix of the caller is written.
// NOLINTNEXTLINE(performance-unnecessary-value-param)
void solve_lower_in_place(const Eigen::MatrixXd& lower, Eigen::Ref<Eigen::MatrixXd> b) {
  lower.triangularView<Eigen::Lower>().solveInPlace(b);
}

Eigen::MatrixXd solve_upper(const Eigen::MatrixXd& upper, const Eigen::MatrixXd& b) {
  return upper.triangularView<Eigen::Upper>().solve(b);
}

Eigen::MatrixXd upper_of_qr(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

Eigen::VectorXd solve_pivoted_qr(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::Vector4d solve_pivoted_qr(const Eigen::MatrixX4d& a, const Eigen::VectorXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

TurnedByQr turn_by_pivoted_qr(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  return {qr.rank(), qr.householderQ().adjoint() * b};
}

Eigen::VectorXd solve_orthogonal(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, std::optional<double> threshold) {
  return orthogonal(a, threshold).solve(b);
}

Eigen::MatrixXd solve_orthogonal(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, std::optional<double> threshold) {
  return orthogonal(a, threshold).solve(b);
}

OrthogonalSolution solve_orthogonal_with_factor(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold) {
  const Orthogonal d = orthogonal(a, threshold);
  OrthogonalSolution solution{d.solve(b), d.rank(), {}};
  // A P = Q [T 0; 0 0] Z, so A^+ = P Z^T [T^-1 0; 0 0] Q^T and F = P Z^T [T^-1; 0]
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(a.cols(), solution.rank);
  inverse.topRows(solution.rank) = d.matrixT()
                                       .topLeftCorner(solution.rank, solution.rank)
                                       .triangularView<Eigen::Upper>()
                                       .solve(Eigen::MatrixXd::Identity(solution.rank, solution.rank));
  if (solution.rank < a.cols()) inverse = (d.matrixZ().transpose() * inverse).eval();
  solution.factor = d.colsPermutation() * inverse;
  return solution;
}

struct SquareQr::Decomposition : Eigen::ColPivHouseholderQR<Eigen::MatrixXd> {
  using ColPivHouseholderQR::ColPivHouseholderQR;
};

SquareQr::SquareQr(Eigen::Index size, double threshold) : qr_(std::make_unique<Decomposition>(size, size)) {
  qr_->setThreshold(threshold);
}

SquareQr::SquareQr(SquareQr&&) noexcept = default;
SquareQr& SquareQr::operator=(SquareQr&&) noexcept = default;
SquareQr::~SquareQr() = default;

Eigen::Index SquareQr::decompose(const Eigen::MatrixXd& a) {
  qr_->compute(a);
  return qr_->rank();
}

void SquareQr::solve(Eigen::VectorXd& b, Eigen::VectorXd& x) const {
  const Eigen::Index n = b.size();
  // A P = Q R with Q = H_1 .. H_n: x = P R^-1 H_n .. H_1 b
  double workspace = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    b.tail(n - k).applyHouseholderOnTheLeft(qr_->matrixQR().col(k).tail(n - k - 1), qr_->hCoeffs()(k), &workspace);
  }
  qr_->matrixQR().triangularView<Eigen::Upper>().solveInPlace(b);
  for (Eigen::Index k = 0; k < n; ++k) x(qr_->colsPermutation().indices()(k)) = b(k);
}

Eigen::MatrixXd solve_lu(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.partialPivLu().solve(b); }

Eigen::Matrix2d inverse(const Eigen::Matrix2d& a) { return a.inverse(); }
Eigen::Matrix3d inverse(const Eigen::Matrix3d& a) { return a.inverse(); }

}  // namespace soak::base
