// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/control_chart.h"

#include <cmath>
#include <numeric>

#include "base/statistics.h"

namespace soak::calib {
namespace {

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double standard_deviation(std::span<const double> values, double mean) {
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

double mean_moving_range(std::span<const double> values) {
  double sum = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) sum += std::abs(values[i] - values[i - 1]);
  return sum / static_cast<double>(values.size() - 1);
}

/// Values that a chart has seen, each with its place.
struct Seen {
  std::vector<std::size_t> places;
  std::vector<double> values;

  void add(std::size_t place, double value) {
    places.push_back(place);
    values.push_back(value);
  }
  /// Those before a place.
  [[nodiscard]] std::span<const double> before(std::size_t place) const {
    std::size_t count = 0;
    while (count < places.size() && places[count] < place) ++count;
    return std::span(values).first(count);
  }
};

/// `ordinary`: the values that are not beyond their own limits, the one that is judged last.
std::optional<ControlShift> shift_of(const Seen& ordinary, const Seen& accepted) {
  if (ordinary.values.size() < kShiftValues) return std::nullopt;
  const std::size_t first = ordinary.places[ordinary.places.size() - kShiftValues];
  const auto limits = control_limits(accepted.before(first), kShiftValues);
  if (!limits) return std::nullopt;
  return ControlShift{mean_of(std::span(ordinary.values).last(kShiftValues)), *limits};
}

}  // namespace

std::optional<ControlLimits> control_limits(std::span<const double> values, std::size_t of) {
  if (values.size() < kFewestForLimits) return std::nullopt;
  ControlLimits limits;
  limits.values = values.size();
  limits.centre = mean_of(values);
  limits.moving_range_upper = kD4 * mean_moving_range(values);
  if (limits.moving_range_upper <= 0.0) return std::nullopt;
  limits.sigma = standard_deviation(values, limits.centre);
  const auto n = static_cast<double>(values.size());
  const double half = base::student_t_two_sided(1.0 - kFalseAlarmPerTest, n - 1.0) * limits.sigma *
                      std::sqrt(1.0 / static_cast<double>(of) + 1.0 / n);
  limits.lower = limits.centre - half;
  limits.upper = limits.centre + half;
  return limits;
}

std::vector<ControlPoint> control_chart(std::span<const double> values) {
  std::vector<ControlPoint> chart;
  Seen accepted;
  Seen ordinary;
  for (std::size_t i = 0; i < values.size(); ++i) {
    ControlPoint& point = chart.emplace_back();
    point.value = values[i];
    if (i > 0) point.moving_range = std::abs(values[i] - values[i - 1]);
    point.limits = control_limits(accepted.values, 1);
    if (!point.beyond_limits()) {
      ordinary.add(i, values[i]);
      point.shift = shift_of(ordinary, accepted);
    }
    const bool is_out = point.beyond_limits() || point.shifted();
    if (point.limits) point.verdict = is_out ? ControlVerdict::out_of_control : ControlVerdict::in_control;
    if (!is_out && accepted.values.size() < kMostForLimits) accepted.add(i, values[i]);
  }
  return chart;
}

}  // namespace soak::calib
