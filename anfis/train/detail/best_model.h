// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "anfis/train/training.h"

namespace soak::anfis::training {

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

}  // namespace soak::anfis::training
