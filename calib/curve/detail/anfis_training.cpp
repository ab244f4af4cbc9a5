// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/anfis_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
/// error.
BestCandidate best_candidate(const AnfisCandidates& candidates, int most, std::optional<int> left_out) {
  BestCandidate best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kShapes.size(); ++i) {
    const anfis::StructureSearch found = anfis::choose_structure(candidates[i], most, left_out);
    const auto chosen = static_cast<std::size_t>(found.chosen - candidates[i].front().memberships);
    if (found.curve[chosen].mean_error >= least) continue;
    least = found.curve[chosen].mean_error;
    best = {kShapes[i], &candidates[i][chosen]};
  }
  return best;
}

/// The model to train of all rows by folds over runs; what the folds have judged is left to the outer folds.
base::Result<anfis::Model> start_of_whole(const AnfisRows& rows, const anfis::TrainingData& condensed,
                                          TrainedFamilies& trained) {
  auto candidates = judge_all(rows, condensed);
  if (!candidates) return base::forward_error(candidates);
  trained.candidates = *std::move(candidates);
  const BestCandidate best = best_candidate(trained.candidates, kMostRules, std::nullopt);
  anfis::RuleBaseOptions structure;
  structure.shape = best.shape;
  structure.memberships = {best.rules->memberships};
  return anfis::grid_rules(condensed, structure);
}

/// The model to train.
base::Result<anfis::Model> start(const AnfisRows& rows, const anfis::TrainingData& learned,
                                 const CurveFitOptions& options, RuleChoice choice, const LeftOut* left_out,
                                 TrainedFamilies& trained) {
  if (options.rules) return asked_rules(learned, *options.rules);
  if (choice == RuleChoice::expected_error) return rules_by_expected_error(learned);
  if (left_out == nullptr) return start_of_whole(rows, learned, trained);
  const BestCandidate best = best_candidate(left_out->whole.candidates, most_rules(learned), left_out->fold);
  return *best.rules->without(left_out->fold);
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
  const bool is_warm = left_out != nullptr && !left_out->whole.candidates.empty();
  auto result = anfis::train_variable_projection(*initial, *learned, is_warm ? fold_learner() : learner());
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
