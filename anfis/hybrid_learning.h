// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "anfis/model.h"
#include "anfis/training_data.h"
#include "base/result.h"

namespace soak::anfis {

/// How train_hybrid learns.
struct HybridOptions {
  int rules = 6;  ///< 2..64
  int order = 1;  ///< of the consequents: 0 or 1
  Membership membership = Membership::bell;
  int epochs = 100;              ///< most epochs; 1 solves for the consequents and moves no premise
  double initial_step = 0.01;    ///< first length of the premise step [AH05 eq. 5.22], in scaled units
  double step_decrease = 0.9;    ///< factor after two zigzags of the error; (0, 1]
  double step_increase = 1.1;    ///< factor after four reductions of the error; >= 1
  double rmse_goal = 0.0;        ///< stop when the training RMSE (units of y) is at most this
  double min_rmse_change = 0.0;  ///< stop when ten epochs lower the least RMSE by less than this share; 0: never

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

enum class StopReason {
  epochs_done,   ///< all epochs made
  goal_reached,  ///< training RMSE at the goal
  converged,     ///< training RMSE changes by less than min_rmse_change
  stationary,    ///< the gradient is zero, or every premise that it would move lies on its bound
  not_finite,    ///< an error or gradient was not finite: the model is the best one before that
};

/// "epochs done", "goal reached"...
[[nodiscard]] std::string_view name(StopReason reason);

/// One epoch of a training.
struct EpochRecord {
  double train_rmse;  ///< units of y
  double check_rmse;  ///< NaN without checking data
  double step;        ///< length of the premise step made after the errors were measured
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

struct Training {
  Model model;
  TrainingSummary summary;
};

/// Hybrid learning of a Takagi-Sugeno system [Jang93; AH05 §5.3]. Premises start as equal memberships equally spaced
/// over the range of the inputs. Each epoch solves for the consequents by whitened, rank-revealing least squares [AH05
/// eq. 5.12-5.13], measures the error E = r^T V^-1 r, and moves the premises by a step of given length against its
/// gradient [AH05 eq. 5.17-5.22], inside the bounds of training/premise_bounds.h.
///
/// The model returned is that of the epoch with the least checking RMSE, or without checking data of the least training
/// RMSE: never the last one for its own sake, never one with a value that is not finite. The same arguments give the
/// same bits.
///
/// With group_variance > 0 each group has a random offset and the curve is the mean over groups; with +infinity the
/// offsets are free and the level of the curve is the plain mean over the groups' levels.
///
/// Refuses (bad_input) options out of range and data that validate() refuses.
[[nodiscard]] base::Result<Training> train_hybrid(const TrainingData& train, const HybridOptions& options,
                                                  const TrainingData* checking = nullptr);

}  // namespace soak::anfis
