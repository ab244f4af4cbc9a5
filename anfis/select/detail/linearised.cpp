// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/linearised.h"

#include <cmath>
#include <string>

#include "anfis/objective/layer.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/train/detail/training_steps.h"

namespace soak::anfis {

Eigen::MatrixXd jacobian(const Model& model, const TrainingData& points) {
  training::Layer layer(model, points);
  layer.compute(model);
  layer.compute_output(model);
  Eigen::MatrixXd consequents(layer.padded_rows(), static_cast<Eigen::Index>(consequent_count(model)));
  layer.consequent_matrix(model, consequents);
  const Eigen::MatrixXd premises = layer.jacobian(model);
  Eigen::MatrixXd all(premises.rows(), consequents.cols() + premises.cols());
  all << consequents.topRows(premises.rows()), premises;
  return all;
}

Linearised linearise(const Model& model, const TrainingData& data, double smoothness, const GroupWhitening& whitening) {
  Linearised fit;
  fit.rows = jacobian(model, data);
  whitening.apply(fit.rows);
  fit.price.resize(0, fit.rows.cols());
  if (smoothness > 0.0) {
    training::CurvaturePenalty penalty(model, data, smoothness * whitening.total_weight());
    fit.price = penalty.jacobian(model);
  }
  return fit;
}

base::Status validate_linearisation(const Model& model, const TrainingData& data, double smoothness) {
  if (auto status = validate(model); !status) return status;
  if (auto status = validate(data, 0); !status) return status;
  if (data.inputs != model.inputs.size()) {
    return base::bad_input("the data have " + std::to_string(data.inputs) + " inputs, the model has " +
                               std::to_string(model.inputs.size()),
                           "x");
  }
  if (std::isinf(data.group_variance)) {
    return base::bad_input("free group offsets leave the level of the curve no finite variance: give an estimate of it",
                           "group_variance");
  }
  return training::validate_smoothness(smoothness, data.inputs);
}

}  // namespace soak::anfis
