// SPDX-License-Identifier: Apache-2.0
#include "calib/control_chart.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace soak::calib {
namespace {

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double mean_moving_range(std::span<const double> values) {
  double sum = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) sum += std::abs(values[i] - values[i - 1]);
  return sum / static_cast<double>(values.size() - 1);
}

/// Whether the last eight values lie on one side of the centre.
bool ends_a_run(double centre, std::span<const double> values) {
  if (values.size() < kControlRun) return false;
  const auto last = values.last(kControlRun);
  return std::ranges::all_of(last, [centre](double value) { return value > centre; }) ||
         std::ranges::all_of(last, [centre](double value) { return value < centre; });
}

}  // namespace

std::optional<ControlLimits> control_limits(std::span<const double> values) {
  if (values.size() < kFewestForLimits) return std::nullopt;
  ControlLimits limits;
  limits.values = values.size();
  limits.centre = mean_of(values);
  limits.mean_moving_range = mean_moving_range(values);
  if (limits.mean_moving_range <= 0.0) return std::nullopt;
  limits.sigma = limits.mean_moving_range / kD2;
  limits.lower = limits.centre - kControlSigmas * limits.sigma;
  limits.upper = limits.centre + kControlSigmas * limits.sigma;
  limits.moving_range_upper = kD4 * limits.mean_moving_range;
  return limits;
}

ControlPoint judge(const ControlLimits& limits, std::span<const double> values) {
  ControlPoint point;
  point.value = values.back();
  if (values.size() > 1) point.moving_range = std::abs(values.back() - values[values.size() - 2]);
  point.limits = limits;
  point.beyond_limits = point.value < limits.lower || point.value > limits.upper;
  point.run = ends_a_run(limits.centre, values);
  point.verdict = point.beyond_limits || point.run ? ControlVerdict::out_of_control : ControlVerdict::in_control;
  return point;
}

std::vector<ControlPoint> control_chart(std::span<const double> values) {
  std::vector<ControlPoint> chart;
  std::vector<double> accepted;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (const auto limits = control_limits(accepted)) {
      chart.push_back(judge(*limits, values.first(i + 1)));
    } else {
      ControlPoint& point = chart.emplace_back();
      point.value = values[i];
      if (i > 0) point.moving_range = std::abs(values[i] - values[i - 1]);
    }
    const bool counts = chart.back().verdict != ControlVerdict::out_of_control;
    if (counts && accepted.size() < kMostForLimits) accepted.push_back(values[i]);
  }
  return chart;
}

}  // namespace soak::calib
