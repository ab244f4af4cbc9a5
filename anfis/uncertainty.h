// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "anfis/model.h"
#include "anfis/training_data.h"
#include "base/result.h"

namespace soak::anfis {

/// Variance of the curve that was fitted, from the model linearised in all its parameters, consequents and premises:
///     var f(x) = sigma^2 j(x)^T (J^T V^-1 J)^+ j(x),   j = df/d parameters, V as in GroupWhitening.
/// The pseudo-inverse comes from the singular values of the whitened Jacobian with unit columns; those below 1e-6 of
/// the largest are left out, as directions in which the parameters move and the curve does not.
///
/// Valid near a minimum, inside the training range, where the model can follow the truth: it knows the noise, not the
/// misfit, and nothing of a choice of rules made on the same data.
class PredictionVariance {
 public:
  /// `data` are the rows that the model was trained on. Refuses (bad_input) invalid models and data, rows that do not
  /// outnumber the effective parameters, and group_variance = +infinity, which leaves the level no finite variance.
  [[nodiscard]] static base::Result<PredictionVariance> of(const Model& model, const TrainingData& data);

  /// Variance of the mean curve at x, squared units of y. sigma_squared scales V: 1 where the weights are 1/variance,
  /// residual_variance() where they are only relative.
  [[nodiscard]] double at(double x, double sigma_squared = 1.0) const;

  /// Number of directions kept: the parameters that the data determine.
  [[nodiscard]] int effective_parameters() const { return static_cast<int>(factor_.cols()); }
  /// rows - effective_parameters(), at least 1.
  [[nodiscard]] int degrees_of_freedom() const { return degrees_of_freedom_; }
  /// r^T V^-1 r / degrees_of_freedom(): near 1 where V is right.
  [[nodiscard]] double residual_variance() const { return residual_variance_; }

 private:
  PredictionVariance() = default;

  Model model_;
  Eigen::MatrixXd factor_;  ///< F F^T = (J^T V^-1 J)^+
  int degrees_of_freedom_ = 0;
  double residual_variance_ = 0.0;
};

}  // namespace soak::anfis
