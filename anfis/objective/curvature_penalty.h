// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
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

  /// Adds d price / d theta to the gradient, in the order of premise_vector.h; after price().
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

}  // namespace soak::anfis::training
