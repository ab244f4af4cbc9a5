// SPDX-License-Identifier: Apache-2.0
#include "curves.h"

#include "support.h"

namespace soak::anfis::test {

VariableProjectionOptions curve_learner() {
  VariableProjectionOptions options;
  options.smoothness = 1e-7;
  return options;
}

VariableProjectionOptions quick_curve_learner() {
  VariableProjectionOptions options = curve_learner();
  options.evaluations = 12;
  options.min_rmse_change = 1e-3;
  return options;
}

StructureSearch search_curve(const TrainingData& data, int folds, Shape shape) {
  StructureSearchOptions options;
  options.rule_base.shape = shape;
  options.learner = quick_curve_learner();
  return search_structure(data, folds_by_group(data, folds), options).value();
}

Model learn_curve(const TrainingData& data, int memberships, Shape shape) {
  return train_variable_projection(grid(data, memberships, shape), data, curve_learner()).value().model;
}

}  // namespace soak::anfis::test
