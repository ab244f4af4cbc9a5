// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/statistics.h"
#include "calib/curve/detail/anfis_training.h"

namespace soak::calib {
namespace {

// How the rows scatter.

constexpr int kComponentIterations = 12;
/// Rows of one plateau lie closer together.
constexpr double kApart_c = 0.5;

/// A floor for the rows' variances, so that a row without a standard error does not weigh infinitely.
double smallest_variance(const CurveData& data) {
  std::vector<double> values;
  std::vector<double> errors;
  for (const CurveRow& row : data.rows) {
    values.push_back(row.value);
    if (row.standard_error > 0.0) errors.push_back(row.standard_error);
  }
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double typical = errors.empty() ? 1e-6 * (*high - *low) : 0.1 * base::median(errors);
  return std::max(typical * typical, 1e-300);
}

struct RowsOffset {
  double weight = 0.0;
  double sum = 0.0;
};

std::size_t count_branches(const CurveData& data) {
  std::set<int> branches;
  for (const CurveRow& row : data.rows) branches.insert(row.branch);
  return branches.size();
}

/// Weighted mean residual of each run (or branch) about the curve.
std::map<int, RowsOffset> common_offsets(const anfis::TrainingData& rows, const Curve& curve) {
  std::map<int, RowsOffset> offsets;
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    RowsOffset& offset = offsets[rows.group[i]];
    offset.weight += rows.weight[i];
    offset.sum += rows.weight[i] * (rows.y[i] - evaluate(curve, rows.x[i]));
  }
  return offsets;
}

/// Variance of estimated offsets, and what noise contributes to it on average.
struct OffsetScatter {
  double estimated = 0.0;
  double noise = 0.0;

  [[nodiscard]] double own() const { return std::max(0.0, estimated - noise); }
};

OffsetScatter offset_scatter(const std::map<int, RowsOffset>& offsets) {
  const double n = static_cast<double>(offsets.size());
  OffsetScatter scatter;
  double mean = 0.0;
  for (const auto& [group, offset] : offsets) {
    mean += offset.sum / offset.weight / n;
    scatter.noise += 1.0 / offset.weight / n;
  }
  double squares = 0.0;
  for (const auto& [group, offset] : offsets) squares += std::pow(offset.sum / offset.weight - mean, 2);
  scatter.estimated = squares / (n - 1.0);
  return scatter;
}

constexpr int kBlockFolds = 5;
constexpr std::size_t kRowsPerBlock = 10;

}  // namespace

std::size_t count_runs(const CurveData& data) {
  std::set<int> runs;
  for (const CurveRow& row : data.rows) runs.insert(row.run);
  return runs.size();
}

std::set<int> judging_runs(const CurveData& data) {
  std::map<int, double> first_c;
  std::set<int> all;
  std::set<int> judges;
  for (const CurveRow& row : data.rows) {
    const auto [first, is_new] = first_c.try_emplace(row.run, row.temp_c);
    all.insert(row.run);
    if (std::abs(row.temp_c - first->second) >= kApart_c) judges.insert(row.run);
  }
  return judges.empty() ? all : judges;
}

bool offsets_by_branch(const CurveData& data) {
  return !data.by_plateau && count_runs(data) == 1 && count_branches(data) > 1;
}

std::size_t count_offsets(const CurveData& data) {
  return offsets_by_branch(data) ? count_branches(data) : count_runs(data);
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

anfis::TrainingData training_data(const CurveData& data, const VarianceComponents& components,
                                  const std::vector<bool>& keep) {
  anfis::TrainingData rows;
  const double floor = smallest_variance(data);
  const double extra = components.lack_of_fit_sigma * components.lack_of_fit_sigma;
  const bool by_branch = offsets_by_branch(data);
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    if (!keep.empty() && !keep[i]) continue;
    const CurveRow& row = data.rows[i];
    rows.x.push_back(row.temp_c);
    rows.y.push_back(row.value);
    rows.weight.push_back(1.0 / (std::max(floor, row.standard_error * row.standard_error) + extra));
    rows.group.push_back(by_branch ? row.branch : row.run);
  }
  const double sigma = (by_branch ? components.branch_sigma : components.run_to_run_sigma).value_or(0.0);
  rows.group_variance = sigma * sigma;
  return rows;
}

base::Result<VarianceComponents> estimate_variance_components(const CurveData& data, double lack_of_fit_sigma) {
  VarianceComponents components;
  components.lack_of_fit_sigma = lack_of_fit_sigma;
  const std::size_t offsets = count_offsets(data);
  Curve curve;
  for (int i = 0; i < kComponentIterations; ++i) {
    anfis::TrainingData rows = training_data(data, components);
    rows.group_variance = offsets > 1 ? std::numeric_limits<double>::infinity() : 0.0;
    const auto fit = fit_smoothing_spline(rows);
    if (!fit) return base::forward_error(fit);
    curve = fit->curve;
    components.degrees_of_freedom =
        static_cast<double>(data.rows.size()) - fit->parameters - (static_cast<double>(offsets) - 1.0);
    if (components.degrees_of_freedom < 1.0) {
      if (i == 0) components.lack_of_fit_sigma = 0.0;  // nothing here bears out where it was begun
      break;
    }
    double mean_variance = 0.0;
    for (const double w : rows.weight) mean_variance += 1.0 / w / static_cast<double>(rows.weight.size());
    const double extra = components.lack_of_fit_sigma * components.lack_of_fit_sigma;
    const double next =
        std::max(0.0, extra + (fit->whitened_rss / components.degrees_of_freedom - 1.0) * mean_variance);
    components.lack_of_fit_sigma = std::sqrt(next);
    if (std::abs(next - extra) < 1e-6 * (extra + mean_variance)) break;
  }
  if (offsets > 1) {
    const anfis::TrainingData rows = training_data(data, components);
    const OffsetScatter scatter = offset_scatter(common_offsets(rows, curve));
    const bool by_branch = offsets_by_branch(data);
    (by_branch ? components.branch_sigma : components.run_to_run_sigma) = std::sqrt(scatter.own());
    if (!by_branch) components.estimated_offset_variance = scatter.estimated;
  }
  return components;
}

base::Result<TrainedFamilies> train_families(const CurveData& data, const CurveFitOptions& options, RuleChoice choice,
                                             const LeftOut* left_out) {
  const auto components =
      estimate_variance_components(data, left_out == nullptr ? 0.0 : left_out->whole.components.lack_of_fit_sigma);
  if (!components) return base::forward_error(components);
  TrainedFamilies trained;
  trained.components = *components;
  anfis::TrainingData rows = training_data(data, *components);
  if (count_offsets(data) < 2) rows.group.clear();

  const auto keep = [&](Family family, base::Result<FittedCurve> fit) {
    if (fit) trained.fitted[static_cast<std::size_t>(family)] = std::move(*fit);
  };
  keep(Family::poly3, fit_polynomial(rows, 3));
  keep(Family::poly5, fit_polynomial(rows, 5));
  auto spline = fit_smoothing_spline(rows);
  if (!spline) return base::forward_error(spline);
  const Curve shape = spline->curve;
  keep(Family::spline, std::move(spline));
  if (left_out != nullptr && !left_out->whole[Family::anfis]) return trained;
  const base::Status learned = train_anfis({rows, shape, judging_runs(data)}, options, choice, left_out, trained);
  // Too few temperatures leave the ANFIS out; a rule count that the user asked for is the user's to mend.
  if (!learned && options.rules) return base::forward_error(learned);
  return trained;
}

}  // namespace soak::calib
