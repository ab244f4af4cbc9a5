// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/premises/premise_bounds.h"
#include "base/result.h"

namespace soak::anfis {

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
  double smoothness = 0.0;       ///< price of curvature, one input only: see ProjectedProblem
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
/// step of given length against its gradient [AH05 eq. 5.17-5.22], inside the bounds of premises/premise_bounds.h. The
/// step follows StepRule.
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

/// Which optimiser of NLopt moves the premises.
enum class Optimiser {
  lbfgs,  ///< limited-memory BFGS with the exact gradient
  slsqp,  ///< sequential quadratic programming with the exact gradient
  sbplx,  ///< subspace simplex, without derivatives: for triangles, trapezoids and the minimum, which have kinks
};

/// How train_variable_projection learns.
struct VariableProjectionOptions {
  Optimiser optimiser = Optimiser::lbfgs;
  int evaluations = 200;                           ///< most evaluations of the error from each start
  double min_rmse_change = 1e-6;                   ///< stop when steps lower the RMSE by less than this share
  double rmse_goal = 0.0;                          ///< stop when the training RMSE (units of y) is at most this
  double smoothness = 0.0;                         ///< price of curvature, one input only: see ProjectedProblem
  PremiseLimits limits = PremiseLimits::resolved;  ///< not `none`: the search needs a box
  int starts = 1;          ///< the first start is the initial model, the others are drawn around it
  double spread = 0.3;     ///< size of the draws: share of a membership's spacing and (log) width
  std::uint64_t seed = 1;  ///< of the draws

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// Variable projection [Golub & Pereyra 1973] of a Takagi-Sugeno system: for given premises the consequents are those
/// of least squares, so that the error is a function of the premises alone, E(theta) = min over consequents of r^T V^-1
/// r. NLopt minimises it in box-bounded coordinates (premises/premise_coordinates.h) that keep memberships inside the
/// range of the data, not narrower than the gaps between inputs, and in order. By the envelope theorem the gradient of
/// E is that of hybrid learning [AH05 eq. 5.17-5.20] at the optimal consequents; curvature comes from the optimiser.
///
/// Where hybrid learning walks a fixed length along steepest descent, this converges: use it unless the data are so
/// large that few epochs must do, or early stopping on checking data is wanted for its own sake. With checking data the
/// best checking model of all evaluations is kept, else the best training model of all starts.
///
/// Refuses what train_hybrid() refuses. The same arguments give the same bits.
[[nodiscard]] base::Result<Training> train_variable_projection(const Model& initial, const TrainingData& train,
                                                               const VariableProjectionOptions& options = {},
                                                               const TrainingData* checking = nullptr);

/// A way to learn with its options. Variable projection unless the user says otherwise: it recovers known systems to
/// rounding where hybrid learning stays a thousandth off, and its thermal curves are the best of bench/. From a single
/// start on noise-free data of several inputs 500 epochs of hybrid learning can end lower: give it more starts.
using Learner = std::variant<VariableProjectionOptions, HybridOptions>;

/// Trains with one or the other: train_variable_projection() or train_hybrid().
[[nodiscard]] base::Result<Training> train(const Model& initial, const TrainingData& data, const Learner& learner,
                                           const TrainingData* checking = nullptr);

}  // namespace soak::anfis
