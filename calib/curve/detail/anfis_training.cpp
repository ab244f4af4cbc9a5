// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/anfis_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "anfis/linear/condensed_rows.h"
#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"

namespace soak::calib {
namespace {

constexpr int kMostRules = 10;
constexpr int kMostInnerFolds = 5;
/// Rows closer together than this share of the range are condensed.
constexpr double kCondensedShare = 0.02;
/// Shapes of membership that compete.
constexpr std::array kShapes = {anfis::Shape::bell, anfis::Shape::gaussian};
/// Price of curvature, for the temperatures that no run visits (docs/decisions/0017-variable-projection.md).
constexpr double kSmoothness = 1e-7;

/// How the model learns.
anfis::VariableProjectionOptions learner() {
  anfis::VariableProjectionOptions options;
  options.smoothness = kSmoothness;
  return options;
}

/// How the candidates of a search learn: their errors settle long before their premises do.
anfis::VariableProjectionOptions quick_learner() {
  anfis::VariableProjectionOptions options = learner();
  options.evaluations = 12;
  options.min_rmse_change = 1e-3;
  return options;
}

/// How the model of an outer fold learns that begins at one of an inner fold: it is judged by rows of which the noise
/// is far larger than what is left then.
anfis::VariableProjectionOptions fold_learner() {
  anfis::VariableProjectionOptions options = learner();
  options.min_rmse_change = 1e-5;
  return options;
}

/// Resolved temperatures that must be left over once every consequent has its own: premises move too.
constexpr int kSpareTemperatures = 2;

/// Most rules that rows carry.
int most_rules(const anfis::TrainingData& rows) {
  return std::min(kMostRules, (anfis::resolved_values(rows) - kSpareTemperatures) / 2);
}

/// What the choice of the number of rules and of the shape by the same rows counts as, in parameters: the one that wins
/// has followed their noise a little. Found with made-up smooth curves of two runs, which the ANFIS else won in 15 %.
constexpr double kChosenStructure = 1.0;

base::Result<anfis::StructureSearchOptions> search_options(const anfis::TrainingData& rows, anfis::Shape shape) {
  anfis::StructureSearchOptions search;
  search.learner = quick_learner();
  search.rule_base.shape = shape;
  search.max_memberships = most_rules(rows);
  if (search.max_memberships < search.min_memberships) return base::bad_input("too few temperatures for two rules");
  return search;
}

/// Least and largest temperature of the rows.
std::pair<double, double> range_of(const anfis::TrainingData& rows) {
  const auto [low, high] = std::minmax_element(rows.x.begin(), rows.x.end());
  return {*low, *high};
}

anfis::Condense condenser(const AnfisRows& rows) {
  const auto [low_c, high_c] = range_of(rows.all);
  const auto value = [&shape = rows.shape](double temp_c) { return evaluate(shape, temp_c); };
  return [width_c = kCondensedShare * (high_c - low_c), value](const anfis::TrainingData& part) {
    return anfis::condense(part, width_c, value);
  };
}

/// What the model learns from. Few runs have few rows, and all of them are learned from.
base::Result<anfis::TrainingData> learned_rows(const AnfisRows& rows, RuleChoice choice) {
  if (choice == RuleChoice::expected_error) return rows.all;
  return condenser(rows)(rows.all);
}

/// Inner folds over runs: at most five, in each as many of the runs that can judge.
std::vector<int> run_folds(const AnfisRows& rows) {
  const int folds = std::min(kMostInnerFolds, static_cast<int>(rows.judges.size()));
  std::map<int, int> fold_of_run;
  int next = 0;
  for (const int run : rows.judges) fold_of_run[run] = next++ % folds;
  std::vector<int> fold;
  for (const int run : rows.all.group) {
    const auto found = fold_of_run.find(run);
    fold.push_back(found == fold_of_run.end() ? anfis::kNoJudge : found->second);
  }
  return fold;
}

/// A model with the rules that the user has asked for.
base::Result<anfis::Model> asked_rules(const anfis::TrainingData& rows, int rules) {
  const int resolved = anfis::resolved_values(rows);
  if (2 * rules >= resolved) {
    return base::bad_input(fmt::format("{} rules have {} consequents; {} temperatures allow at most {} rules", rules,
                                       2 * rules, resolved, (resolved - 1) / 2));
  }
  anfis::RuleBaseOptions structure;
  structure.memberships = {rules};
  return anfis::grid_rules(rows, structure);
}

/// The structure with the least expected error on all rows, over both shapes.
base::Result<anfis::Model> rules_by_expected_error(const anfis::TrainingData& rows) {
  anfis::RuleBaseOptions structure;
  double least = std::numeric_limits<double>::infinity();
  for (const anfis::Shape shape : kShapes) {
    const auto search = search_options(rows, shape);
    if (!search) return base::forward_error(search);
    const auto found = anfis::search_structure(rows, *search);
    if (!found) return base::forward_error(found);
    if (found->expected_error >= least) continue;
    least = found->expected_error;
    structure.shape = shape;
    structure.memberships = {found->memberships};
  }
  return anfis::grid_rules(rows, structure);
}

/// All structures of both shapes, judged by inner folds.
base::Result<AnfisCandidates> judge_all(const AnfisRows& rows, const anfis::TrainingData& condensed) {
  AnfisCandidates candidates;
  for (const anfis::Shape shape : kShapes) {
    const auto search = search_options(condensed, shape);
    if (!search) return base::forward_error(search);
    auto judged = anfis::judge_structures(rows.all, run_folds(rows), *search, condenser(rows));
    if (!judged) return base::forward_error(judged);
    candidates.push_back(*std::move(judged));
  }
  return candidates;
}

/// A chosen number of rules of one shape.
struct BestCandidate {
  anfis::Shape shape{};
  const anfis::JudgedCandidate* rules = nullptr;
};

/// The rules of each shape are chosen by themselves, `most` at most; of the shapes the one whose choice has the lesser
/// error. Refuses candidates of which none can be chosen.
base::Result<BestCandidate> best_candidate(const AnfisCandidates& candidates, int most, std::optional<int> left_out) {
  BestCandidate best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const anfis::StructureSearch found = anfis::choose_structure(candidates[i], most, left_out);
    if (found.chosen == 0) continue;
    const auto chosen = static_cast<std::size_t>(found.chosen - candidates[i].front().memberships);
    if (!(found.curve[chosen].mean_error < least)) continue;
    least = found.curve[chosen].mean_error;
    best = {kShapes[i], &candidates[i][chosen]};
  }
  if (best.rules == nullptr) return base::bad_input("the runs left out choose no number of rules");
  return best;
}

base::Result<anfis::Model> grid_of(const BestCandidate& best, const anfis::TrainingData& rows) {
  anfis::RuleBaseOptions structure;
  structure.shape = best.shape;
  structure.memberships = {best.rules->memberships};
  return anfis::grid_rules(rows, structure);
}

/// The model to train of all rows by folds over runs; what the folds have judged is left to the outer folds.
base::Result<anfis::Model> start_of_whole(const AnfisRows& rows, const anfis::TrainingData& condensed,
                                          TrainedFamilies& trained) {
  auto candidates = judge_all(rows, condensed);
  if (!candidates) return base::forward_error(candidates);
  trained.candidates = *std::move(candidates);
  const auto best = best_candidate(trained.candidates, kMostRules, std::nullopt);
  if (!best) return base::forward_error(best);
  return grid_of(*best, condensed);
}

/// A model to train, and how it learns.
struct Start {
  anfis::Model model;
  anfis::VariableProjectionOptions learner;
};

/// Whether a model has learned from the range of these rows. Else its scales are those of another range, and none of
/// its rules is where the rows are new.
bool has_range_of(const anfis::TrainingData& rows, const anfis::Model& model) {
  const auto [low_c, high_c] = range_of(rows);
  const anfis::Input& temperature = model.inputs[0];
  const double apart_c = std::max(std::abs(temperature.min - low_c), std::abs(temperature.max - high_c));
  return apart_c <= kCondensedShare * (high_c - low_c);
}

/// The model to train of the rows of an outer fold: that of the inner fold which has not learned from the run left out
/// either, or a grid where it has seen another range of temperatures.
base::Result<Start> start_of_fold(const anfis::TrainingData& condensed, const LeftOut& left_out) {
  const auto best = best_candidate(left_out.whole.candidates, most_rules(condensed), left_out.fold);
  if (!best) return base::forward_error(best);
  const anfis::Model* inner = best->rules->without(left_out.fold);
  if (inner == nullptr) return base::bad_input("no inner fold has left this run out");
  if (has_range_of(condensed, *inner)) return Start{*inner, fold_learner()};
  auto grid = grid_of(*best, condensed);
  if (!grid) return base::forward_error(grid);
  return Start{*std::move(grid), learner()};
}

base::Result<Start> start(const AnfisRows& rows, const anfis::TrainingData& learned, const CurveFitOptions& options,
                          RuleChoice choice, const LeftOut* left_out, TrainedFamilies& trained) {
  const bool by_folds = !options.rules && choice == RuleChoice::folds_over_runs;
  if (by_folds && left_out != nullptr) return start_of_fold(learned, *left_out);
  auto model = options.rules ? asked_rules(learned, *options.rules)
               : by_folds    ? start_of_whole(rows, learned, trained)
                             : rules_by_expected_error(learned);
  if (!model) return base::forward_error(model);
  return Start{*std::move(model), learner()};
}

base::Status add_variance(const anfis::Model& model, const anfis::TrainingData& rows, const CurveFitOptions& options,
                          FittedCurve& fitted) {
  auto linearised = anfis::PredictionVariance::of(model, rows, kSmoothness);
  if (!linearised) return base::forward_error(linearised);
  const auto variance = std::make_shared<const anfis::PredictionVariance>(*std::move(linearised));
  fitted.variance = [variance](double temp_c) { return variance->at(temp_c); };
  fitted.parameters = variance->effective_parameters() + (options.rules ? 0.0 : kChosenStructure);
  return {};
}

}  // namespace

base::Status train_anfis(const AnfisRows& rows, const CurveFitOptions& options, RuleChoice choice,
                         const LeftOut* left_out, TrainedFamilies& trained) {
  const auto learned = learned_rows(rows, choice);
  if (!learned) return base::forward_error(learned);
  const auto initial = start(rows, *learned, options, choice, left_out, trained);
  if (!initial) return base::forward_error(initial);
  auto result = anfis::train_variable_projection(initial->model, *learned, initial->learner);
  if (!result) return base::forward_error(result);
  FittedCurve fitted;
  const double total_weight = std::accumulate(learned->weight.begin(), learned->weight.end(), 0.0);
  fitted.whitened_rss = result->summary.train_rmse * result->summary.train_rmse * total_weight;
  if (left_out == nullptr) {
    if (auto status = add_variance(result->model, *learned, options, fitted); !status) return status;
  }
  trained.rules = static_cast<int>(result->model.rules.size());
  trained.membership = anfis::name(result->model.inputs[0].memberships.front().shape);
  trained.training = result->summary.one_line();
  // The curve is of all rows, not only of what lies between their condensed temperatures.
  std::tie(result->model.inputs[0].min, result->model.inputs[0].max) = range_of(rows.all);
  fitted.curve = std::move(result->model);
  trained.fitted[static_cast<std::size_t>(Family::anfis)] = std::move(fitted);
  return {};
}

}  // namespace soak::calib
