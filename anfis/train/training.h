// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "anfis/model/model.h"

namespace soak::anfis {

/// What premises may become in a training; see training/premise_bounds.h.
enum class PremiseLimits {
  resolved,  ///< memberships and their edges no narrower than the gaps between inputs: for noisy data
  ordered,   ///< memberships in order, centres inside the data: for data without noise that fill the input space
  none,      ///< whatever the gradient says [Jang93]: hybrid learning only
};

/// Why a training stopped.
enum class StopReason {
  epochs_done,   ///< all epochs or evaluations made
  goal_reached,  ///< training RMSE at the goal
  converged,     ///< the training RMSE changes by less than min_rmse_change, or the optimiser's own tolerance is met
  stationary,    ///< the gradient is zero, or every premise that it would move lies on its bound
  collapsed,   ///< without limits a step took a membership's shape (slope or order): the model is the best before that
  patience,    ///< the checking RMSE has not fallen for `patience` epochs
  not_finite,  ///< an error or gradient was not finite: the model is the best one before that
};

/// "epochs done", "goal reached"...
[[nodiscard]] std::string_view name(StopReason reason);

/// One epoch of a training, or one evaluation of variable projection.
struct EpochRecord {
  double train_rmse;  ///< units of y
  double check_rmse;  ///< NaN without checking data
  double step;        ///< length of the premise step made after the errors were measured; NaN in variable projection
};

/// What happened in a training.
struct TrainingSummary {
  StopReason reason = StopReason::epochs_done;
  int best_epoch = 0;                ///< from 1: the epoch whose model was kept
  double train_rmse = 0.0;           ///< of the model kept: sqrt(r^T V^-1 r / sum of weights), V as in GroupWhitening
  double check_rmse = 0.0;           ///< of the model kept: shape_rmse of the checking data; NaN without them
  std::vector<EpochRecord> history;  ///< one record per epoch made

  [[nodiscard]] std::string one_line() const;
};

/// A trained model and how it came about.
struct Training {
  Model model;
  TrainingSummary summary;
};

}  // namespace soak::anfis
