// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/group_whitening.h"
#include "anfis/hybrid_learning.h"
#include "anfis/training/premise_bounds.h"
#include "anfis/training/premise_layer.h"

namespace soak::anfis::training {

/// Scaling of the data and the premises that training starts from: `rules` equal memberships equally spaced over the
/// range of x, neighbours crossing at degree 1/2 [Jang93]; consequents 0.
[[nodiscard]] Model initial_model(const TrainingData& data, const HybridOptions& options);

/// Inputs or outputs of the rows in the scaled units of the model.
[[nodiscard]] std::vector<double> scaled_inputs(const Model& model, const TrainingData& data);
[[nodiscard]] Eigen::VectorXd scaled_outputs(const Model& model, const TrainingData& data);

/// The two halves of an epoch of hybrid learning on one set of data.
class Trainer {
 public:
  Trainer(const TrainingData& data, const HybridOptions& options);

  /// Forward pass: consequents of the present premises. Returns the training RMSE in units of y; not finite where the
  /// problem broke down.
  double solve_consequents();

  /// Backward pass: moves the premises by `step` against the gradient. False where there is no direction to move in or
  /// it is not finite; the premises are unchanged then.
  bool move_premises(double step);

  [[nodiscard]] const Model& model() const { return model_; }

  /// Gradient of E = r^T V^-1 r (r in scaled units, V in those of y) by the premises, in the premise members of each
  /// Rule.
  [[nodiscard]] std::vector<Rule> gradient() const;

 private:
  HybridOptions options_;
  Model model_;
  GroupWhitening whitening_;
  std::vector<double> inputs_;
  Eigen::VectorXd outputs_;
  Eigen::VectorXd whitened_outputs_;
  Eigen::VectorXd whitened_residuals_;
  PremiseLayer layer_;
  PremiseBounds bounds_;
};

}  // namespace soak::anfis::training
