// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <set>

#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"

namespace soak::calib {
namespace {

constexpr int kBlockFolds = 5;
constexpr std::size_t kRowsPerBlock = 10;
constexpr int kMostInnerFolds = 5;
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
/// Resolved temperatures that must be left over once every consequent has its own: premises move too.
constexpr int kSpareTemperatures = 2;

/// Inner folds over runs: at most five, each run whole in one of them.
std::vector<int> run_folds(const CurveData& data) {
  std::set<int> runs;
  for (const CurveRow& row : data.rows) runs.insert(row.run);
  std::vector<int> folds;
  for (const CurveRow& row : data.rows) {
    folds.push_back(static_cast<int>(std::distance(runs.begin(), runs.find(row.run))) % kMostInnerFolds);
  }
  return folds;
}

/// For each shape the fewest rules within one standard error of its least error over inner folds; of the shapes the one
/// whose choice has the lesser error.
base::Result<anfis::RuleBaseOptions> choose_structure(const CurveData& data, const anfis::TrainingData& rows,
                                                      const CurveFitOptions& options) {
  anfis::RuleBaseOptions structure;
  const int resolved = anfis::resolved_values(rows);
  if (options.rules) {
    if (2 * *options.rules >= resolved) {
      return base::bad_input(fmt::format("{} rules have {} consequents; {} temperatures carry at most {} rules",
                                         *options.rules, 2 * *options.rules, resolved, (resolved - 1) / 2));
    }
    structure.memberships = {*options.rules};
    return structure;
  }
  anfis::StructureSearchOptions search;
  search.learner = quick_learner();
  search.max_memberships = std::min(kMostRules, (resolved - kSpareTemperatures) / 2);
  if (search.max_memberships < search.min_memberships) return base::bad_input("too few temperatures for two rules");
  const std::vector<int> folds = count_runs(data) > 1 ? run_folds(data) : block_folds(data);
  double least = std::numeric_limits<double>::infinity();
  for (const anfis::Shape shape : kShapes) {
    search.rule_base.shape = shape;
    const auto found = anfis::search_structure(rows, folds, search);
    if (!found) return base::forward_error(found);
    const double error = found->curve[static_cast<std::size_t>(found->chosen - search.min_memberships)].mean_error;
    if (error >= least) continue;
    least = error;
    structure.shape = shape;
    structure.memberships = {found->chosen};
  }
  return structure;
}

base::Status train_anfis(const CurveData& data, const anfis::TrainingData& rows, const CurveFitOptions& options,
                         TrainedFamilies& trained) {
  const auto structure = choose_structure(data, rows, options);
  if (!structure) return base::forward_error(structure);
  const auto initial = anfis::grid_rules(rows, *structure);
  if (!initial) return base::forward_error(initial);
  const auto result = anfis::train_variable_projection(*initial, rows, learner());
  if (!result) return base::forward_error(result);
  auto linearised = anfis::PredictionVariance::of(result->model, rows, kSmoothness);
  if (!linearised) return base::forward_error(linearised);
  const auto variance = std::make_shared<const anfis::PredictionVariance>(*std::move(linearised));
  FittedCurve fitted;
  fitted.curve = result->model;
  fitted.variance = [variance](double temp_c) { return variance->at(temp_c); };
  fitted.parameters = variance->effective_parameters();
  const double total_weight = std::accumulate(rows.weight.begin(), rows.weight.end(), 0.0);
  fitted.whitened_rss = result->summary.train_rmse * result->summary.train_rmse * total_weight;
  trained.rules = static_cast<int>(result->model.rules.size());
  trained.membership = anfis::name(structure->shape);
  trained.training = result->summary.one_line();
  trained.fitted[static_cast<std::size_t>(Family::anfis)] = std::move(fitted);
  return {};
}

}  // namespace

std::size_t count_runs(const CurveData& data) {
  std::set<int> runs;
  for (const CurveRow& row : data.rows) runs.insert(row.run);
  return runs.size();
}

std::vector<int> block_folds(const CurveData& data) {
  // Few rows still have to reach every fold.
  const std::size_t block = std::clamp<std::size_t>(data.rows.size() / (2 * kBlockFolds), 1, kRowsPerBlock);
  std::vector<int> folds;
  for (std::size_t i = 0; i < data.rows.size(); ++i) folds.push_back(static_cast<int>(i / block) % kBlockFolds);
  return folds;
}

CurveData select(const CurveData& data, const std::vector<bool>& keep) {
  CurveData selected = data;
  selected.rows.clear();
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    if (keep[i]) selected.rows.push_back(data.rows[i]);
  }
  return selected;
}

base::Result<TrainedFamilies> train_families(const CurveData& data, const CurveFitOptions& options) {
  const auto components = estimate_variance_components(data);
  if (!components) return base::forward_error(components);
  TrainedFamilies trained;
  trained.components = *components;
  anfis::TrainingData rows = training_data(data, *components);
  if (count_runs(data) < 2) rows.group.clear();

  const auto keep = [&](Family family, base::Result<FittedCurve> fit) {
    if (fit) trained.fitted[static_cast<std::size_t>(family)] = std::move(*fit);
  };
  keep(Family::poly3, fit_polynomial(rows, 3));
  keep(Family::poly5, fit_polynomial(rows, 5));
  auto spline = fit_smoothing_spline(rows);
  if (!spline) return base::forward_error(spline);
  keep(Family::spline, std::move(spline));
  const base::Status learned = train_anfis(data, rows, options, trained);
  // Too few temperatures leave the ANFIS out; a rule count that the user asked for is the user's to mend.
  if (!learned && options.rules) return base::forward_error(learned);
  return trained;
}

}  // namespace soak::calib
