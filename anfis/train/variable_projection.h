// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/train/training.h"
#include "base/result.h"

namespace soak::anfis {

/// Which optimiser of NLopt moves the premises.
enum class Optimiser {
  lbfgs,  ///< limited-memory BFGS with the exact gradient
  slsqp,  ///< sequential quadratic programming with the exact gradient
  sbplx,  ///< subspace simplex, without derivatives: for triangles, trapezoids and the minimum, which have kinks
};

/// How train_variable_projection learns.
struct VariableProjectionOptions {
  Optimiser optimiser = Optimiser::lbfgs;
  int evaluations = 200;          ///< most evaluations of the error from each start
  double min_rmse_change = 1e-6;  ///< stop when steps lower the RMSE by less than this share
  double rmse_goal = 0.0;         ///< stop when the training RMSE (units of y) is at most this
  double smoothness = 0.0;        ///< price of curvature, one input only: see training/projected_problem.h
  PremiseLimits limits = PremiseLimits::resolved;  ///< not `none`: the search needs a box
  int starts = 1;          ///< the first start is the initial model, the others are drawn around it
  double spread = 0.3;     ///< size of the draws: share of a membership's spacing and (log) width
  std::uint64_t seed = 1;  ///< of the draws

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// Variable projection [Golub & Pereyra 1973] of a Takagi-Sugeno system: for given premises the consequents are those
/// of least squares, so that the error is a function of the premises alone, E(theta) = min over consequents of r^T V^-1
/// r. NLopt minimises it in box-bounded coordinates (training/premise_coordinates.h) that keep memberships inside the
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

}  // namespace soak::anfis
