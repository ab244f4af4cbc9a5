// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/linear/dense_solve.h"

namespace soak::anfis::training {

/// Least squares in the epoch loop: what solve_least_squares() of anfis/linear/least_squares.h computes, without
/// allocating memory. Rows are condensed to a triangular factor first (training/kernels.h), block by block so that each
/// stays in the cache; its columns are then scaled and pivoted to reveal the rank. Only a rank-deficient problem goes
/// to the general solver for its solution of least norm.
class ConsequentSolver {
 public:
  ConsequentSolver(Eigen::Index rows, Eigen::Index columns);

  /// x that minimises || A x - b ||; valid until the next call. Not finite where A or b is not.
  const Eigen::VectorXd& solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

 private:
  void condense(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
  Eigen::Index scale_and_decompose();

  Eigen::Index block_;      ///< rows condensed at a time
  Eigen::MatrixXd work_;    ///< a block of A and b under the factor of those before it
  Eigen::MatrixXd factor_;  ///< R of both
  Eigen::VectorXd scale_;
  Eigen::MatrixXd scaled_;
  base::SquareQr qr_;
  Eigen::VectorXd right_;
  Eigen::VectorXd solution_;
};

}  // namespace soak::anfis::training
