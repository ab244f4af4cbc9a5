// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/model/rule_base.h"
#include "anfis/train/learner.h"
#include "base/result.h"

namespace soak::anfis {

/// Which structures to try: grids of the same number of memberships on each input.
struct StructureSearchOptions {
  int min_memberships = 2;
  /// Lowered so that consequents are at most 3/4 of the resolved inputs; with 2 memberships or a learner that prices
  /// curvature: fewer than those.
  int max_memberships = 10;
  RuleBaseOptions rule_base;  ///< of every candidate; its `memberships` is ignored
  Learner learner;            ///< of every candidate
};

/// One candidate of a structure search.
struct StructureSearchPoint {
  int memberships;  ///< of each input
  int rules;
  double mean_error;      ///< mean over folds of the held-out shape RMSE, units of y
  double standard_error;  ///< of that mean
  double excess;          ///< mean over folds of (error - error of the best candidate in the same fold)
  double excess_error;    ///< standard error of the excess
};

/// Fold of the rows that are learned from in every fold and judge nothing.
inline constexpr int kNoJudge = -1;

struct StructureSearch {
  std::vector<StructureSearchPoint> curve;  ///< in rising order of memberships
  int best = 0;                             ///< memberships with the least mean error
  int chosen = 0;                           ///< the fewest memberships whose excess is at most one excess_error
};

/// Chooses the number of rules by cross-validation. fold: id of the fold of each row, or kNoJudge; groups (runs) must
/// not be split over folds, as a run's own offset would leak otherwise. Each candidate is trained on all folds but one
/// and judged on that one by shape_rmse: the held-out groups' own offsets are removed, weights count. The choice is the
/// fewest rules whose mean error exceeds the least one by no more than one standard error of the paired difference.
///
/// What it cannot see: folds over runs share their temperatures, so that an error between temperatures that no run
/// visits costs nothing here. The bounds of the premises stand against that (premises/premise_bounds.h).
///
/// Refuses (bad_input) fewer than two folds, groups split over folds, options out of range, and data that leave no
/// candidate. Cost: candidates x folds trainings.
[[nodiscard]] base::Result<StructureSearch> search_structure(const TrainingData& data, std::span<const int> fold,
                                                             const StructureSearchOptions& options);

/// A structure and what it is expected to err.
struct StructureChoice {
  int memberships = 0;          ///< of each input
  double expected_error = 0.0;  ///< expected_squared_error() of the candidate
};

/// Expected squared error of fitted values, summed over the rows in units of their variances, up to a constant that all
/// models of these rows share: r^T V^-1 r + 2 p with p effective parameters [Mallows 1973, C_p]. The weights must be
/// 1/variance.
[[nodiscard]] constexpr double expected_squared_error(double whitened_rss, double parameters) {
  return whitened_rss + 2.0 * parameters;
}

/// Chooses the number of rules without folds, for data of few groups: what is left out of those is either most of what
/// there is, or a stretch in the middle that doubles the widest gap and so halves the rules that can be tried. Each
/// candidate is trained on all rows; the choice has the least expected_squared_error(). Noise that rows share beyond
/// their groups' offsets counts as shape.
///
/// Refuses (bad_input) options out of range and data that leave no candidate. Cost: one training per candidate.
[[nodiscard]] base::Result<StructureChoice> search_structure(const TrainingData& data,
                                                             const StructureSearchOptions& options);

/// How far a candidate that has not learned from a group lies from its rows.
struct GroupError {
  int group = 0;         ///< of data without groups 0, once for each fold
  int fold = 0;          ///< with which the group was left out
  double weight = 0.0;   ///< of its rows
  double squares = 0.0;  ///< weight times shape_rmse() squared
};

/// One number of memberships, judged on each group by models that learned from other folds.
struct JudgedCandidate {
  int memberships = 0;
  std::vector<GroupError> errors;
  std::map<int, Model> models;  ///< by fold: the one that has not learned from it

  /// The model that has not learned from a group; null where none has left it out. Needs data with groups: without
  /// them nothing says which rows are meant.
  [[nodiscard]] const Model* without(int group) const;
};

/// What stands for the rows of a fold in a training.
using Condense = std::function<base::Result<TrainingData>(const TrainingData&)>;

/// The trainings of search_structure() with folds, each on what `condense` makes of the rows of its fold, and their
/// errors on every group left out. Groups of fold kNoJudge are learned from in every fold and judge nothing. Refuses
/// (bad_input) what search_structure() refuses, and what `condense` refuses.
[[nodiscard]] base::Result<std::vector<JudgedCandidate>> judge_structures(const TrainingData& data,
                                                                          std::span<const int> fold,
                                                                          const StructureSearchOptions& options,
                                                                          const Condense& condense);
/// The choice of search_structure() among the candidates with `most` memberships at most (but the fewest there are).
/// `left_out`: a group whose errors do not count, which needs data with groups; the others must be of two folds, else
/// nothing is chosen (0).
[[nodiscard]] StructureSearch choose_structure(std::span<const JudgedCandidate> candidates, int most,
                                               std::optional<int> left_out = std::nullopt);

/// Number of values of one input that count as different ones: walking up the sorted values, the next one at least half
/// the widest gap above the last counted. The scatter of a plateau over runs counts once.
[[nodiscard]] int resolved_values(const TrainingData& data, std::size_t input = 0);

}  // namespace soak::anfis
