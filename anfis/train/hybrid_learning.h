// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/train/training.h"
#include "base/result.h"

namespace soak::anfis {

/// How an epoch finds the consequents.
enum class ConsequentSolver {
  least_squares,  ///< whitened, rank-revealing QR [AH05 eq. 5.12-5.13]
  sequential,     ///< recursive least squares from 0 and initial_covariance, anew in each epoch [AH05 eq. 5.14]
};

/// How train_hybrid learns.
struct HybridOptions {
  int epochs = 100;              ///< most epochs; 1 solves for the consequents and moves no premise
  double initial_step = 0.01;    ///< first length of the premise step [AH05 eq. 5.22], in scaled units
  double step_decrease = 0.9;    ///< factor after two zigzags of the error; (0, 1]
  double step_increase = 1.1;    ///< factor after four reductions of the error; >= 1
  double rmse_goal = 0.0;        ///< stop when the training RMSE (units of y) is at most this
  double min_rmse_change = 0.0;  ///< stop when ten epochs lower the least RMSE by less than this share; 0: never
  int patience = 0;              ///< stop when the checking RMSE has not fallen for so many epochs; 0: never
  double smoothness = 0.0;       ///< price of curvature, one input only: see training/projected_problem.h
  PremiseLimits limits = PremiseLimits::resolved;
  ConsequentSolver solver = ConsequentSolver::least_squares;
  double initial_covariance = 1e6;  ///< eta of the sequential solver, S_0 = eta I
  bool keep_by_training_error =
      false;  ///< keep the model of the least training error even where checking data are given

  /// The conventions of MATLAB's anfis as far as they are known: sequential consequents from 1e6 I in every epoch, no
  /// bounds, ten epochs, the model of the least training error. Start it from grid_rules() with scale = false and two
  /// bells per input. Sequential least squares cannot take groups: such data are refused.
  [[nodiscard]] static HybridOptions matlab();

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// Hybrid learning of a Takagi-Sugeno system [Jang93; AH05 §5.3], starting from the premises of `initial`
/// (grid_rules(), scatter_rules(), fuzzy_ols() or the user's own). Each epoch solves for the consequents by whitened,
/// rank-revealing least squares [AH05 eq. 5.12-5.13], measures the error E = r^T V^-1 r, and moves the premises by a
/// step of given length against its gradient [AH05 eq. 5.17-5.22], inside the bounds of training/premise_bounds.h. The
/// step follows training/step_rule.h.
///
/// The model returned is that of the epoch with the least checking RMSE, or without checking data of the least E
/// (with a price of curvature: with it): never the last one for its own sake, never one with a value that is not
/// finite. The same arguments give the same bits, on every instruction set. An epoch allocates no memory, unless the
/// consequents are rank-deficient (free offsets of groups with order 1 always are).
///
/// With group_variance > 0 each group has a random offset and the curve is the mean over groups; with +infinity the
/// offsets are free and the level of the curve is the plain mean over the groups' levels.
///
/// Refuses (bad_input) options out of range, models that validate() refuses, and data that it refuses or that have
/// another number of inputs than the model.
[[nodiscard]] base::Result<Training> train_hybrid(const Model& initial, const TrainingData& train,
                                                  const HybridOptions& options = {},
                                                  const TrainingData* checking = nullptr);

}  // namespace soak::anfis
