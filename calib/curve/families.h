// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/select/structure_search.h"
#include "base/result.h"
#include "calib/curve/baselines.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/curve_data.h"

namespace soak::calib {

/// How the rows of a thermal fit scatter about a smooth curve.
struct VarianceComponents {
  /// Standard deviation of the rows within a run beyond their own standard errors: what no function of the thermometer
  /// follows (hysteresis, drift).
  double lack_of_fit_sigma = 0.0;
  /// Standard deviation of the runs' offsets; absent with fewer than two runs.
  std::optional<double> run_to_run_sigma;
  /// Variance of the runs' offsets as they were estimated: that of run_to_run_sigma before what noise contributes was
  /// taken off, so never cut off at zero. Over the number of runs it is the variance of their mean, and as an estimate
  /// it has a chi-squared distribution with one degree of freedom less than there are runs.
  std::optional<double> estimated_offset_variance;
  /// Standard deviation of the branches' offsets; only where offsets_by_branch(), which then stand for the runs'.
  std::optional<double> branch_sigma;
  double degrees_of_freedom = 0.0;  ///< of the scatter within runs
};

/// Whether the rows' common offsets are those of the branches of the temperature history: one recording without
/// plateaus, in which each branch covers a range of its own. Without offsets a mean curve would step where a branch
/// ends.
[[nodiscard]] bool offsets_by_branch(const CurveData& data);

/// Number of different offsets: branches under offsets_by_branch(), else runs.
[[nodiscard]] std::size_t count_offsets(const CurveData& data);

/// Method of moments about a smoothing spline with free run offsets: the variance added to each row's own is the one
/// that makes the weighted residuals as large as they should be; the offsets' variance is that of the estimated offsets
/// less what noise contributes. `lack_of_fit_sigma`: where the search begins.
[[nodiscard]] base::Result<VarianceComponents> estimate_variance_components(const CurveData& data,
                                                                            double lack_of_fit_sigma = 0.0);

/// The rows of `data` whose flag is set (all, where `keep` is empty) as training data under the given components.
[[nodiscard]] anfis::TrainingData training_data(const CurveData& data, const VarianceComponents& components,
                                                const std::vector<bool>& keep = {});

/// Numbers of rules of the ANFIS, by kind of membership, each judged on runs that it has not learned from.
using AnfisCandidates = std::vector<std::vector<anfis::JudgedCandidate>>;

/// All families fitted to the same rows; absent where the rows have too few temperatures for one.
struct TrainedFamilies {
  VarianceComponents components;
  std::array<std::optional<FittedCurve>, kFamilyCount> fitted;
  int rules = 0;
  std::string membership;
  std::string training;        ///< one line about the ANFIS' training
  AnfisCandidates candidates;  ///< of a whole fit by RuleChoice::folds_over_runs without a number of rules given

  [[nodiscard]] const std::optional<FittedCurve>& operator[](Family family) const {
    return fitted[static_cast<std::size_t>(family)];
  }
};

/// How the number of ANFIS rules is chosen.
enum class RuleChoice { expected_error, folds_over_runs };

/// By inner folds over runs (anfis::judge_structures) where there are more than kRunsWithoutFolds, else
/// by the expected error on all rows (anfis::search_structure).
inline constexpr std::size_t kRunsWithoutFolds = 3;
/// Part of a `baseline_deployed` warning of so few runs; the report tells them by it from those judged on held-out
/// runs.
inline constexpr std::string_view kFewRunsAreNoJudge = "so few runs are no judge when held out";
/// `runs`: those that can be judges (judging_runs()).
[[nodiscard]] constexpr RuleChoice rule_choice(std::size_t runs) {
  return runs > kRunsWithoutFolds ? RuleChoice::folds_over_runs : RuleChoice::expected_error;
}

/// The fit of all rows, and the outer fold that has been left out of them: the run where folds are runs.
struct LeftOut {
  const TrainedFamilies& whole;
  int fold = 0;
};

/// Fits every family to the rows. `choice`: that of the whole fit, also where an outer fold has left a run out of the
/// rows; folds over runs need two that have been at several temperatures. With `left_out` the curves alone are wanted:
/// the ANFIS has no variance then. By folds over runs it has the structure that the inner folds of the whole fit choose
/// by their errors on the other runs, and its training begins where the inner fold without that run has ended, or at a
/// grid where that fold has seen another range of temperatures.
[[nodiscard]] base::Result<TrainedFamilies> train_families(const CurveData& data, const CurveFitOptions& options,
                                                           RuleChoice choice, const LeftOut* left_out = nullptr);

/// Fold of each row by stretches of time, five folds taken in turn.
[[nodiscard]] std::vector<int> block_folds(const CurveData& data);

/// The rows whose flag is set.
[[nodiscard]] CurveData select(const CurveData& data, const std::vector<bool>& keep);

/// Number of different runs among the rows.
[[nodiscard]] std::size_t count_runs(const CurveData& data);

/// The runs that can judge a curve: those whose rows lie half a kelvin or more apart. A power-on that stayed at one
/// plateau shows the level, and its own offset hides what it says of the shape. Where no run left its plateau: all.
[[nodiscard]] std::set<int> judging_runs(const CurveData& data);

}  // namespace soak::calib
