// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/anfis_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>

#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"

namespace soak::calib {
namespace {

constexpr int kMostRules = 10;
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

/// How the model of an outer fold learns that begins at a trained one: it is judged by rows of which the noise is far
/// larger than what is left then.
anfis::VariableProjectionOptions fold_learner() {
  anfis::VariableProjectionOptions options = learner();
  options.min_rmse_change = 1e-4;
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

/// All structures of both shapes, trained and judged on each run by the others.
base::Result<AnfisCandidates> judge_all(const anfis::CondensedRows& rows) {
  AnfisCandidates candidates;
  for (const anfis::Shape shape : kShapes) {
    const auto search = search_options(rows.rows, shape);
    if (!search) return base::forward_error(search);
    auto judged = anfis::judge_structures(rows, *search);
    if (!judged) return base::forward_error(judged);
    candidates.push_back(*std::move(judged));
  }
  return candidates;
}

/// The rules of each shape are chosen by themselves, `most` at most (but the fewest there are); of the shapes the one
/// whose choice has the lesser error.
const anfis::Model& best_candidate(const AnfisCandidates& candidates, int most, std::optional<std::size_t> left_out) {
  const anfis::Model* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& all_of_shape : candidates) {
    const auto carried = std::ranges::count_if(all_of_shape, [most](const anfis::JudgedCandidate& candidate) {
      return candidate.model.rules.size() <= static_cast<std::size_t>(std::max(0, most));
    });
    const std::span of_shape(all_of_shape.begin(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, carried)));
    const anfis::CandidateChoice choice = anfis::choose_structure(of_shape, left_out);
    if (best != nullptr && !(choice.mean_error < least)) continue;
    least = choice.mean_error;
    best = &of_shape[choice.index].model;
  }
  return *best;
}

bool same_structure(const anfis::Model& a, const anfis::Model& b) {
  return a.rules.size() == b.rules.size() &&
         a.inputs[0].memberships.front().shape == b.inputs[0].memberships.front().shape;
}

/// Where the training of a fold begins: at the model of all rows, if that has the structure that the fold chooses among
/// those that its own rows carry.
anfis::Model start_of_fold(const LeftOut& left_out, const anfis::TrainingData& rows) {
  const auto& whole = std::get<anfis::Model>(left_out.whole[Family::anfis]->curve);
  if (left_out.whole.candidates.empty()) return whole;
  const anfis::Model& chosen = best_candidate(left_out.whole.candidates, most_rules(rows), left_out.run);
  return same_structure(chosen, whole) ? whole : chosen;
}

/// The model to train, and for the whole fit what its folds take over.
base::Result<anfis::Model> start(const anfis::CondensedRows& rows, const CurveFitOptions& options, RuleChoice choice,
                                 const LeftOut* left_out, TrainedFamilies& trained) {
  if (choice == RuleChoice::held_out_runs && left_out != nullptr) return start_of_fold(*left_out, rows.rows);
  if (options.rules) return asked_rules(rows.rows, *options.rules);
  if (choice == RuleChoice::expected_error) return rules_by_expected_error(rows.rows);
  auto candidates = judge_all(rows);
  if (!candidates) return base::forward_error(candidates);
  trained.candidates = *std::move(candidates);
  return best_candidate(trained.candidates, kMostRules, std::nullopt);
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

base::Status train_anfis(const std::pair<double, double>& range_c, const anfis::CondensedRows& rows,
                         const CurveFitOptions& options, RuleChoice choice, const LeftOut* left_out,
                         TrainedFamilies& trained) {
  const auto initial = start(rows, options, choice, left_out, trained);
  if (!initial) return base::forward_error(initial);
  const bool is_warm = choice == RuleChoice::held_out_runs && left_out != nullptr;
  auto result = anfis::train_variable_projection(*initial, rows.rows, is_warm ? fold_learner() : learner());
  if (!result) return base::forward_error(result);
  FittedCurve fitted;
  const double total_weight = std::accumulate(rows.rows.weight.begin(), rows.rows.weight.end(), 0.0);
  fitted.whitened_rss = result->summary.train_rmse * result->summary.train_rmse * total_weight;
  if (left_out == nullptr) {
    if (auto status = add_variance(result->model, rows.rows, options, fitted); !status) return status;
  }
  trained.rules = static_cast<int>(result->model.rules.size());
  trained.membership = anfis::name(result->model.inputs[0].memberships.front().shape);
  trained.training = result->summary.one_line();
  // The curve is of all rows, not only of what lies between their condensed temperatures.
  result->model.inputs[0].min = range_c.first;
  result->model.inputs[0].max = range_c.second;
  fitted.curve = std::move(result->model);
  trained.fitted[static_cast<std::size_t>(Family::anfis)] = std::move(fitted);
  return {};
}

}  // namespace soak::calib
