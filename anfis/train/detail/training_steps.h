// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/train/learner.h"
#include "base/result.h"

namespace soak::anfis::training {

/// One option of a learner: whether its value is sound, and what would be.
struct OptionCheck {
  const char* option;
  double value;
  bool sound;
  const char* range;
};

/// Refuses (bad_input) the first option that is not sound: "epochs is 0: it must be 1..1000000".
[[nodiscard]] base::Status check_options(std::span<const OptionCheck> checks);

/// Whether a model can be trained on data: both valid, as many inputs, no fewer distinct rows than consequents.
/// Checking data must have groups where free offsets of the training data leave the level open until the end.
[[nodiscard]] base::Status validate_arguments(const Model& initial, const TrainingData& train, double smoothness,
                                              const TrainingData* checking);

/// Whether a price of curvature is not negative and, where there is one, the curve has one input.
[[nodiscard]] base::Status validate_smoothness(double smoothness, std::size_t inputs);

/// The training, or the refusal where its model is none that can be evaluated or its errors are not finite.
[[nodiscard]] base::Result<Training> usable(Training training);

/// The refusal when not even the first solution is finite.
[[nodiscard]] tl::unexpected<base::Error> unusable_numbers();

/// Keeps the best model of a training: the first with the least checking error, or with the least E (see
/// ProjectedProblem), which has the price of curvature in it. Allocates nothing after construction.
class BestModel {
 public:
  /// `shape` has the structure of the models to come; by_checking: judge by the checking error, else by E.
  BestModel(const Model& shape, bool by_checking) : model_(shape), by_checking_(by_checking) {}

  void offer(const Model& model, const EpochRecord& record, double e, int epoch) {
    const double error = by_checking_ ? record.check_rmse : e;
    if (epoch_ != 0 && !(error < error_)) return;
    model_ = model;
    record_ = record;
    epoch_ = epoch;
    error_ = error;
  }

  [[nodiscard]] bool empty() const { return epoch_ == 0; }
  [[nodiscard]] int epoch() const { return epoch_; }
  [[nodiscard]] double error() const { return error_; }

  [[nodiscard]] Training training(StopReason reason, std::vector<EpochRecord> history) && {
    return {std::move(model_), {reason, epoch_, record_.train_rmse, record_.check_rmse, std::move(history)}};
  }

 private:
  Model model_;
  bool by_checking_;
  EpochRecord record_{};
  int epoch_ = 0;
  double error_ = 0.0;
};

/// Length of the premise step from the training errors so far [Jang93; AH05 §6.4.3 corrected]:
///  - four reductions in a row: times `increase`;
///  - two combinations of a rise and a reduction in a row (rise, reduction, rise, reduction): times `decrease`;
///  - after a change, the same kind of change waits for four epochs (a counter for each kind, both starting at the
///    first epoch). A reduction of the step is tested first. A factor of 1 switches its kind off.
class StepRule {
 public:
  StepRule(double initial_step, double decrease, double increase)
      : step_(initial_step), decrease_(decrease), increase_(increase) {}

  [[nodiscard]] double step() const { return step_; }

  /// Takes the training error of the epoch whose step has just been made; the step is that of the next epoch then.
  void record(double rmse);

 private:
  [[nodiscard]] bool last_four_are(const std::array<bool, 4>& reduction) const;

  double step_;
  double decrease_;
  double increase_;
  std::array<double, 5> errors_{};  ///< of the last five epochs
  int epochs_ = 0;
  int last_decrease_ = 1;  ///< epoch, from 1
  int last_increase_ = 1;
};

}  // namespace soak::anfis::training
