// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anfis/model/model.h"
#include "anfis/train/learner.h"
#include "anfis/train/online_consequents.h"
#include "base/result.h"
#include "nav/learned/error_windows.h"

namespace soak::nav {

/// How an error grows after the last fix: of the position as the square of the time, of the velocity as the time.
class ErrorGrowth {
 public:
  void add(double since_fix_s, const ErrorOutputs& error);
  /// The standard deviation that fits the errors so far; 0 before the first.
  [[nodiscard]] ErrorOutputs sigma_after(double since_fix_s) const;

 private:
  ErrorOutputs squares_ = ErrorOutputs::Zero();
  ErrorOutputs shapes_ = ErrorOutputs::Zero();
};

/// What Takagi-Sugeno systems say of a filter's error without fixes, one for each output.
struct ErrorModel {
  std::array<anfis::Model, kErrorOutputs> outputs;
  ErrorGrowth growth;  ///< of what they leave of the errors that they have learnt
};

/// An error that is expected, and the standard deviation of what it is wrong by. Of an output of which nothing is
/// known the error is 0 and the standard deviation kUnknownError.
struct ExpectedError {
  ErrorOutputs error;
  ErrorOutputs sigma;
};
inline constexpr double kUnknownError = 1e6;

/// The error that the model expects; sigma from what it left of the errors that it learnt. Inputs beyond those it has
/// learnt from are taken for the nearest of these.
[[nodiscard]] ExpectedError expected_error(const ErrorModel& model, const ErrorInputs& inputs);

/// How learn_errors() learns: by default as suits many outages of several drives.
struct ErrorLearning {
  std::vector<int> rules = {4};        ///< numbers of rules to try
  double consequent_threshold = 0.02;  ///< of anfis::FuzzyOlsOptions
  std::size_t every = 5;               ///< each so many-th row of an outage is learnt: neighbours say nearly the same
  std::optional<anfis::Learner> refinement = {};  ///< of premises and consequents afterwards
};

/// Structure and consequents by Fuzzy-OLS from artificial outages, those of several drives if possible [AH05 §7.1.1,
/// §5.4]; rows of an outage are held out together. Fails as anfis::fuzzy_ols() does, which wants more rows than the
/// least number of rules needs, and no input that is constant.
[[nodiscard]] base::Result<ErrorModel> learn_errors(std::span<const ErrorWindow> windows,
                                                    const ErrorLearning& learning = {});

/// An error model that follows a drive: its consequents learn from one artificial outage after the other, and each
/// outage is first foretold, then learnt. What was foretold says whether to believe it.
///
/// What other drives taught weighs much: most of what is new on this drive is still to learn after the 18 outages of
/// ten minutes. The bound of the consequents' variance says how fast it learns, more than the window does.
class FollowingErrorModel {
 public:
  /// `rows_per_window`: 1 / (1 - forgetting) of the consequents, in rows; see above. Fails as anfis::OnlineConsequents
  /// does.
  [[nodiscard]] static base::Result<FollowingErrorModel> of(const ErrorModel& model, double rows_per_window);

  /// Foretells the errors of the outage, notes how well, and learns them.
  void follow(const ErrorWindow& window);

  /// The error that it expects, sigma from what was foretold wrongly; nothing is known where what was foretold did not
  /// carry: see carries().
  [[nodiscard]] ExpectedError expected(const ErrorInputs& inputs) const;

  /// Whether corrections by what was foretold would have made the errors of past outages smaller: in the mean over
  /// outages by more than chance does in one case of 40 (Student's t), in at least four outages. East and north are
  /// judged together, up by itself, position and velocity apart.
  [[nodiscard]] bool carries(std::size_t output) const;

 private:
  explicit FollowingErrorModel(std::vector<anfis::OnlineConsequents> outputs) : outputs_(std::move(outputs)) {}
  [[nodiscard]] ErrorOutputs foretell(const ErrorInputs& inputs) const;

  struct Score {
    ErrorOutputs before;  ///< root mean square of the errors
    ErrorOutputs after;   ///< of what the corrections would have left
  };
  std::vector<anfis::OnlineConsequents> outputs_;
  std::vector<Score> scores_;  ///< one per outage
  ErrorGrowth growth_;
};

}  // namespace soak::nav
