// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/detail/training_arguments.h"

#include <cmath>
#include <string>

#include "base/text.h"

namespace soak::anfis::training {
namespace {

base::Status same_inputs(const Model& model, const TrainingData& data) {
  if (data.inputs == model.inputs.size()) return {};
  return base::bad_input(
      "the data have " + std::to_string(data.inputs) + " inputs, the model has " + std::to_string(model.inputs.size()),
      "x");
}

base::Status validate_checking(const Model& model, const TrainingData& checking) {
  auto status = validate(checking, 0);
  if (status) status = same_inputs(model, checking);
  if (!status) status.error().where = "checking data, " + status.error().where;
  return status;
}

}  // namespace

base::Status validate_arguments(const Model& initial, const TrainingData& train, double smoothness,
                                const TrainingData* checking) {
  if (auto status = validate(initial); !status) {
    status.error().where = "initial model, " + status.error().where;
    return status;
  }
  if (auto status = validate(train, 0); !status) return status;
  if (auto status = same_inputs(initial, train); !status) return status;
  if (auto status = validate(train, consequent_count(initial)); !status) return status;
  if (auto status = validate_smoothness(smoothness, train.inputs); !status) return status;
  if (checking == nullptr) return {};
  if (std::isinf(train.group_variance) && checking->group_variance == 0.0) {
    return base::bad_input(
        "free offsets leave the level of the curve open in training: give the checking data groups too",
        "checking data, group_variance");
  }
  return validate_checking(initial, *checking);
}

base::Status validate_smoothness(double smoothness, std::size_t inputs) {
  if (!(smoothness >= 0.0) || !std::isfinite(smoothness)) {
    return base::bad_input("smoothness is " + base::shortest(smoothness) + ": it must be 0 or positive", "smoothness");
  }
  if (smoothness > 0.0 && inputs != 1) {
    return base::bad_input(
        "smoothness prices the curvature of curves: with " + std::to_string(inputs) + " inputs it must be 0",
        "smoothness");
  }
  return {};
}

base::Result<Training> usable(Training training) {
  const TrainingSummary& summary = training.summary;
  if (!validate(training.model) || !std::isfinite(summary.train_rmse) || std::isinf(summary.check_rmse)) {
    return unusable_numbers();
  }
  return training;
}

tl::unexpected<base::Error> unusable_numbers() {
  return base::bad_input("the numbers are too large or too small for least squares: change the units of x, y or weight",
                         "first epoch");
}

}  // namespace soak::anfis::training
