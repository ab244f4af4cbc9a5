// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/variance_components.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/statistics.h"
#include "calib/curve/baselines.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

constexpr int kIterations = 12;

std::size_t count_runs(const CurveData& data) {
  std::vector<int> ids;
  for (const CurveRow& row : data.rows) ids.push_back(row.run);
  std::sort(ids.begin(), ids.end());
  return static_cast<std::size_t>(std::unique(ids.begin(), ids.end()) - ids.begin());
}

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

struct Offset {
  double weight = 0.0;
  double sum = 0.0;
};

/// Weighted mean residual of each run about the curve.
std::map<int, Offset> run_offsets(const CurveData& data, const anfis::TrainingData& rows, const Curve& curve) {
  std::map<int, Offset> offsets;
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    Offset& offset = offsets[data.rows[i].run];
    offset.weight += rows.weight[i];
    offset.sum += rows.weight[i] * (rows.y[i] - evaluate(curve, rows.x[i]));
  }
  return offsets;
}

double offset_variance(const std::map<int, Offset>& offsets) {
  const double n = static_cast<double>(offsets.size());
  double mean = 0.0;
  double noise = 0.0;
  for (const auto& [run, offset] : offsets) {
    mean += offset.sum / offset.weight / n;
    noise += 1.0 / offset.weight / n;
  }
  double squares = 0.0;
  for (const auto& [run, offset] : offsets) squares += std::pow(offset.sum / offset.weight - mean, 2);
  return std::max(0.0, squares / (n - 1.0) - noise);
}

}  // namespace

anfis::TrainingData training_data(const CurveData& data, const VarianceComponents& components,
                                  const std::vector<bool>& keep) {
  anfis::TrainingData rows;
  const double floor = smallest_variance(data);
  const double extra = components.lack_of_fit_sigma * components.lack_of_fit_sigma;
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    if (!keep.empty() && !keep[i]) continue;
    const CurveRow& row = data.rows[i];
    rows.x.push_back(row.temp_c);
    rows.y.push_back(row.value);
    rows.weight.push_back(1.0 / (std::max(floor, row.standard_error * row.standard_error) + extra));
    rows.group.push_back(row.run);
  }
  const double sigma = components.run_to_run_sigma.value_or(0.0);
  rows.group_variance = sigma * sigma;
  return rows;
}

base::Result<VarianceComponents> estimate_variance_components(const CurveData& data) {
  VarianceComponents components;
  const std::size_t runs = count_runs(data);
  Curve curve;
  for (int i = 0; i < kIterations; ++i) {
    anfis::TrainingData rows = training_data(data, components);
    rows.group_variance = runs > 1 ? std::numeric_limits<double>::infinity() : 0.0;
    const auto fit = fit_smoothing_spline(rows);
    if (!fit) return base::forward_error(fit);
    curve = fit->curve;
    components.degrees_of_freedom =
        static_cast<double>(data.rows.size()) - fit->parameters - (runs > 1 ? static_cast<double>(runs) - 1.0 : 0.0);
    if (components.degrees_of_freedom < 1.0) break;
    double mean_variance = 0.0;
    for (const double w : rows.weight) mean_variance += 1.0 / w / static_cast<double>(rows.weight.size());
    const double extra = components.lack_of_fit_sigma * components.lack_of_fit_sigma;
    const double next =
        std::max(0.0, extra + (fit->whitened_rss / components.degrees_of_freedom - 1.0) * mean_variance);
    components.lack_of_fit_sigma = std::sqrt(next);
    if (std::abs(next - extra) < 1e-6 * (extra + mean_variance)) break;
  }
  if (runs > 1) {
    const anfis::TrainingData rows = training_data(data, components);
    components.run_to_run_sigma = std::sqrt(offset_variance(run_offsets(data, rows, curve)));
  }
  return components;
}

}  // namespace soak::calib
