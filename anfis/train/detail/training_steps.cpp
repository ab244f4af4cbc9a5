// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/detail/training_steps.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.h"

namespace soak::anfis {

std::string_view name(StopReason reason) {
  constexpr std::array<std::string_view, 7> kNames = {"epochs done", "goal reached", "converged", "stationary",
                                                      "collapsed",   "patience",     "not finite"};
  const auto index = static_cast<std::size_t>(reason);
  return index < kNames.size() ? kNames[index] : "unknown";
}

std::string TrainingSummary::one_line() const {
  std::string line(name(reason));
  line += " after " + std::to_string(history.size()) + " epochs, best " + std::to_string(best_epoch) + ", train RMSE ";
  line += base::shortest(train_rmse);
  if (!std::isnan(check_rmse)) line += ", check RMSE " + base::shortest(check_rmse);
  return line;
}

base::Result<Training> train(const Model& initial, const TrainingData& data, const Learner& learner,
                             const TrainingData* checking) {
  if (const auto* hybrid = std::get_if<HybridOptions>(&learner)) return train_hybrid(initial, data, *hybrid, checking);
  return train_variable_projection(initial, data, std::get<VariableProjectionOptions>(learner), checking);
}

}  // namespace soak::anfis

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

constexpr int kWait = 4;
constexpr std::array<bool, 4> kFourReductions = {true, true, true, true};
constexpr std::array<bool, 4> kTwoZigzags = {false, true, false, true};

}  // namespace

base::Status check_options(std::span<const OptionCheck> checks) {
  for (const OptionCheck& check : checks) {
    if (check.sound) continue;
    return base::bad_input(
        std::string(check.option) + " is " + base::shortest(check.value) + ": it must be " + check.range, check.option);
  }
  return {};
}

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

void StepRule::record(double rmse) {
  std::shift_left(errors_.begin(), errors_.end(), 1);
  errors_.back() = rmse;
  ++epochs_;
  if (decrease_ != 1.0 && epochs_ >= last_decrease_ + kWait && last_four_are(kTwoZigzags)) {
    step_ *= decrease_;
    last_decrease_ = epochs_;
  } else if (increase_ != 1.0 && epochs_ >= last_increase_ + kWait && last_four_are(kFourReductions)) {
    step_ *= increase_;
    last_increase_ = epochs_;
  }
}

bool StepRule::last_four_are(const std::array<bool, 4>& reduction) const {
  for (std::size_t i = 0; i < 4; ++i) {
    const double before = errors_[i];
    const double after = errors_[i + 1];
    if (reduction[i] ? !(after < before) : !(after > before)) return false;
  }
  return true;
}

}  // namespace soak::anfis::training
