// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/linear/group_whitening.h"
#include "anfis/linear/sequential_least_squares.h"
#include "anfis/model/model.h"
#include "anfis/objective/consequent_solver.h"
#include "anfis/objective/curvature_penalty.h"
#include "anfis/objective/layer.h"

namespace soak::anfis::training {

/// The error of a model on some data as a function of its premises alone: the consequents are those of least squares,
///     E(theta) = min over consequents of r^T V^-1 r + smoothness W integral f''(u)^2 du,
/// r and f in scaled units, V as in GroupWhitening, W the sum of weights.
/// Nothing is allocated after construction (but see ConsequentSolver).
class ProjectedProblem {
 public:
  /// The structure of `model` stays; its parameters are where the search begins.
  /// initial_covariance is that of solve_sequentially().
  ProjectedProblem(const Model& model, const TrainingData& data, double smoothness = 0.0,
                   double initial_covariance = 1e6);

  /// Solves for the consequents of the present premises [AH05 eq. 5.12-5.13] and returns the training RMSE,
  /// sqrt(r^T V^-1 r / W) in units of y; not finite where the problem broke down.
  double solve();

  /// The same by recursive least squares from 0 and S_0 = initial_covariance I, row by row [AH05 eq. 5.14].
  double solve_sequentially();

  /// dE/d theta at the consequents of the last solution [AH05 eq. 5.17-5.20], in the order of premise_vector.h. They
  /// are optimal, so that their own change with the premises adds nothing.
  void gradient(std::span<double> gradient);

  /// E of the last solution.
  [[nodiscard]] double error() const { return error_; }
  /// The part of r^T V^-1 r in it is this times the square of the RMSE.
  [[nodiscard]] double error_per_square_rmse() const;

  [[nodiscard]] const Model& model() const { return model_; }
  /// For moving the premises.
  [[nodiscard]] Model& model() { return model_; }

 private:
  void compute_rows();
  double measure();

  Model model_;
  Layer layer_;
  GroupWhitening whitening_;
  Eigen::VectorXd outputs_;  ///< scaled
  std::optional<CurvaturePenalty> curvature_;
  Eigen::MatrixXd a_;      ///< whitened, then the rows of the penalty
  Eigen::VectorXd right_;  ///< whitened outputs, then a zero per row of the penalty
  ConsequentSolver solver_;
  double error_ = 0.0;
  Eigen::VectorXd residuals_;  ///< whitened
  Eigen::VectorXd pull_;       ///< dE/df
  SequentialLeastSquares sequential_;
  Eigen::VectorXd sequential_row_;
};

/// Error of models of one structure on rows that they do not learn from: shape_rmse() without allocating memory.
class CheckingError {
 public:
  CheckingError(const Model& model, const TrainingData& data);

  double operator()(const Model& model);

 private:
  Layer layer_;
  GroupWhitening whitening_;
  Eigen::VectorXd outputs_;
  Eigen::VectorXd residuals_;
};

}  // namespace soak::anfis::training
