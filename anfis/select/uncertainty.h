// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// Variance of the curve that was fitted, from the model linearised in all its parameters, consequents and premises:
///     var f(x) = sigma^2 j(x)^T (J^T V^-1 J + P)^+ j(x),   j = df/d parameters, V as in GroupWhitening,
/// P the curvature penalty of the training (0 for smoothness 0): with it this is the Bayesian variance, which covers
/// the smoothing bias on average, as for smoothing splines [Nychka 1988]. The pseudo-inverse comes from the singular
/// values of the whitened Jacobian with unit columns; those below 1e-6 of the largest are left out, as directions in
/// which the parameters move and the curve does not.
///
/// Valid near a minimum, inside the training range, where the model can follow the truth: it knows the noise, not the
/// misfit, and nothing of a choice of rules made on the same data.
class PredictionVariance {
 public:
  /// `data` are the rows that the model was trained on. Refuses (bad_input) invalid models and data, rows that do not
  /// outnumber the effective parameters, and group_variance = +infinity, which leaves the level no finite variance.
  /// smoothness: that of the training, 0 for models with several inputs.
  [[nodiscard]] static base::Result<PredictionVariance> of(const Model& model, const TrainingData& data,
                                                           double smoothness = 0.0);

  /// Variance of the mean curve at the point x (one value per input), squared units of y. sigma_squared scales V: 1
  /// where the weights are 1/variance, residual_variance() where they are only relative.
  [[nodiscard]] double at(std::span<const double> x, double sigma_squared = 1.0) const;
  /// The same for a model with one input.
  [[nodiscard]] double at(double x, double sigma_squared = 1.0) const;

  /// Number of parameters that the data determine: the directions kept, each by the share that the penalty leaves it.
  [[nodiscard]] double effective_parameters() const { return effective_parameters_; }
  /// rows - effective_parameters(), at least 1.
  [[nodiscard]] double degrees_of_freedom() const { return degrees_of_freedom_; }
  /// r^T V^-1 r / degrees_of_freedom(): near 1 where V is right.
  [[nodiscard]] double residual_variance() const { return residual_variance_; }

 private:
  PredictionVariance() = default;

  Model model_;
  Eigen::MatrixXd factor_;  ///< F F^T = (J^T V^-1 J)^+
  double effective_parameters_ = 0.0;
  double degrees_of_freedom_ = 0.0;
  double residual_variance_ = 0.0;
};

/// PredictionVariance::effective_parameters() by itself, from the normal equations: an order of magnitude quicker, and
/// good to three digits or so, for comparing many models. Refuses what PredictionVariance::of() refuses but for too few
/// rows.
[[nodiscard]] base::Result<double> effective_parameters(const Model& model, const TrainingData& data,
                                                        double smoothness);

}  // namespace soak::anfis
