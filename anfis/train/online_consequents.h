// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "anfis/linear/least_squares.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// How OnlineConsequents learns.
struct OnlineOptions {
  double forgetting = 0.99;         ///< lambda, (0, 1]: the window is about 1/(1 - lambda) rows; 1 forgets nothing
  double initial_covariance = 1e6;  ///< eta, S_0 = eta I in scaled units; (0, 1e9]. Small: trust the given consequents

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// Sliding-window learning of a Takagi-Sugeno system [AH05 §5.3.3]: premises stay, consequents follow the data row by
/// row through recursive least squares with forgetting, starting from those of the given model. The row of a rule is
/// its normalised strength times (u, 1) [AH05 eq. 5.11], without the gains that order or Rule::dropped hold at 0.
///
/// A row that lies k rows back weighs lambda^k: half the weight is on the last 0.69/(1 - lambda) rows. Rules that the
/// window does not visit keep their consequents; see SequentialLeastSquares for what bounds their variance.
class OnlineConsequents {
 public:
  /// Refuses (bad_input) options out of range and models that anfis::validate() refuses.
  [[nodiscard]] static base::Result<OnlineConsequents> of(Model model, const OnlineOptions& options = {});

  /// Learns the row x (one value per input) -> y, units of the training data. Refuses (bad_input), and leaves the
  /// consequents as they are: another number of inputs, values that are not finite, x outside the range of the model,
  /// where its premises say nothing, and a y so large that consequents would leave the limits of a valid model
  /// (the covariance begins anew then: the window is lost).
  [[nodiscard]] base::Status update(std::span<const double> x, double y);

  /// The model as of the last row.
  [[nodiscard]] const Model& model() const { return model_; }

 private:
  OnlineConsequents(Model model, const OnlineOptions& options);

  void set_regressors(std::span<const double> x);

  Model model_;
  SequentialLeastSquares solver_;
  std::vector<double> strengths_;
  Eigen::VectorXd regressors_;  ///< rule by rule: those of its gains, then that of its offset
};

}  // namespace soak::anfis
