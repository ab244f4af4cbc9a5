// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/linear/least_squares.h"
#include "anfis/model/model.h"
#include "anfis/objective/consequents.h"
#include "anfis/objective/layer.h"

namespace soak::anfis::training {

/// The price of a curve's curvature in a training of one input: factor * integral of f''(u)^2 du over the range of the
/// data, in scaled units, by second differences on an even grid: a quarter of the widest gap between inputs, but 32 to
/// 256 intervals. Between inputs, where no error speaks, it chooses the smoothest of the curves that fit alike.
class CurvaturePenalty {
 public:
  /// The structure of the model is fixed, as in Layer.
  CurvaturePenalty(const Model& model, const TrainingData& data, double factor);

  /// Number of rows that it adds to the least squares of the consequents.
  [[nodiscard]] Eigen::Index rows() const { return layer_.padded_rows(); }

  /// Those rows for the premises of the model: || rows x ||^2 is the price of the consequents x.
  void consequent_rows(const Model& model, Eigen::Ref<Eigen::MatrixXd> rows);

  /// Jacobian by consequents, then premises, of the numbers whose squares make up the price, for a model with all its
  /// parameters.
  [[nodiscard]] Eigen::MatrixXd jacobian(const Model& model);

  /// The price of the model whose premises consequent_rows() has seen.
  double price(const Model& model);

  /// Adds d price / d theta to the gradient, in the order of read_premises(); after price().
  void add_gradient(const Model& model, std::span<double> gradient);

 private:
  [[nodiscard]] Eigen::Index inner() const { return static_cast<Eigen::Index>(layer_.rows()) - 2; }

  Layer layer_;
  double scale_;                 ///< of a second difference, so that the price is a sum of squares
  Eigen::MatrixXd consequents_;  ///< regressors on the grid
  Eigen::VectorXd difference_;
  Eigen::VectorXd pull_;
  std::vector<double> own_gradient_;
};

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

  /// dE/d theta at the consequents of the last solution [AH05 eq. 5.17-5.20], in the order of read_premises(). They
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
  double squares_within_ = 0.0;  ///< scaled
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
