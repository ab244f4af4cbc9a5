// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "anfis/hybrid_learning.h"
#include "anfis/training_data.h"
#include "base/result.h"

namespace soak::anfis {

struct RuleSearchOptions {
  int min_rules = 2;
  int max_rules =
      10;  ///< lowered so that consequents are at most 3/4 of the resolved inputs (2 rules: fewer than those)
  HybridOptions training;  ///< of every candidate; its `rules` is ignored
};

/// One candidate of a rule search.
struct RuleSearchPoint {
  int rules;
  double mean_error;      ///< mean over folds of the held-out shape RMSE, units of y
  double standard_error;  ///< of that mean
  double excess;          ///< mean over folds of (error - error of the best candidate in the same fold)
  double excess_error;    ///< standard error of the excess
};

struct RuleSearch {
  std::vector<RuleSearchPoint> curve;  ///< in rising order of rules
  int best = 0;                        ///< rules with the least mean error
  int chosen = 0;                      ///< the fewest rules whose excess is at most one excess_error
};

/// Chooses the number of rules by cross-validation. fold: id of the fold of each row; groups (runs) must not be split
/// over folds, as a run's own offset would leak otherwise. Each candidate is trained on all folds but one and judged on
/// that one by shape_rmse: the held-out groups' own offsets are removed, weights count. The choice is the fewest rules
/// whose mean error exceeds the least one by no more than one standard error of the paired difference.
///
/// What it cannot see: folds over runs share their temperatures, so that an error between temperatures that no run
/// visits costs nothing here. The bounds of the premises stand against that (training/premise_bounds.h).
///
/// Refuses (bad_input) fewer than two folds, groups split over folds, options out of range, and data that leave no
/// candidate.
[[nodiscard]] base::Result<RuleSearch> search_rules(const TrainingData& data, std::span<const int> fold,
                                                    const RuleSearchOptions& options);

/// Number of inputs that count as different ones: walking up the sorted inputs, the next one at least half the widest
/// gap above the last counted. The scatter of a plateau over runs counts once.
[[nodiscard]] int resolved_inputs(const TrainingData& data);

}  // namespace soak::anfis
