// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/table_form.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "anfis/model/one_input.h"
#include "calib/deploy/detail/difference.h"

namespace soak::calib {
namespace {

// The step is a whole multiple of this part of a power of two near it, so that float32 carries the temperatures of all
// points without rounding, and the reader's differences from them too.
constexpr double kGrainsPerStep = 16.0;
constexpr double kLeastGrain_c = 0x1p-14;

/// Equally spaced temperatures that cover a range: the last may lie beyond its end, by less than a step and by less
/// than a grain for each point.
struct Grid {
  double first_c = 0.0;
  double step_c = 1.0;
  std::size_t count = 1;

  [[nodiscard]] double at(std::size_t i) const { return first_c + step_c * static_cast<double>(i); }
};

/// The grain that leaves steps and temperatures with few digits.
double coarse_grain_c(double min_c, double max_c, int points) {
  const double ideal = (max_c - min_c) / (points - 1);
  return std::max(kLeastGrain_c, std::exp2(std::floor(std::log2(ideal / kGrainsPerStep))));
}

Grid grid_over(double min_c, double max_c, int points, double grain) {
  const double intervals = points - 1;
  Grid grid;
  grid.first_c = grain * std::floor(min_c / grain);
  grid.step_c = grain * std::max(1.0, std::ceil((max_c - grid.first_c) / intervals / grain));
  grid.count = static_cast<std::size_t>(std::ceil((max_c - grid.first_c) / grid.step_c)) + 1;
  return grid;
}

/// Value at `at_c` of the line through the curve at end_c and inner_c.
double on_line(const Curve& curve, double at_c, double end_c, double inner_c) {
  const double end = evaluate(curve, end_c);
  if (inner_c == end_c) return end;
  return end + (evaluate(curve, inner_c) - end) * (at_c - end_c) / (inner_c - end_c);
}

/// The curve at the points; at the two outermost, which may lie outside the range, such that the table meets the curve
/// at the range's ends.
TableCurve tabulate(const Curve& curve, double min_c, double max_c, const Grid& grid) {
  TableCurve table{grid.first_c, grid.step_c, {}, std::nullopt};
  for (std::size_t i = 0; i < grid.count; ++i) {
    table.values.push_back(evaluate(curve, std::clamp(grid.at(i), min_c, max_c)));
  }
  if (grid.count < 2) return table;
  const std::size_t last = grid.count - 1;
  table.values[0] = on_line(curve, grid.at(0), min_c, std::min(grid.at(1), max_c));
  table.values[last] = on_line(curve, grid.at(last), max_c, std::max(grid.at(last - 1), min_c));
  return table;
}

bool is_small_table(const Curve& curve, int points) {
  const auto* table = std::get_if<TableCurve>(&curve);
  return table != nullptr && table->values.size() <= static_cast<std::size_t>(points);
}

base::Status check_evaluable(const Curve& curve) {
  const auto* model = std::get_if<anfis::Model>(&curve);
  if (model == nullptr) return {};
  if (auto status = anfis::validate(*model); !status) return status;
  return anfis::validate_curve(*model);
}

/// The table of a curve over the part of the valid range that lies in its domain. Where that is not the whole range the
/// table ends where the curve does: a reader tells by it where the curve was measured.
TableCurve table_over(const Curve& curve, const SensorCalibration& sensor, int points) {
  const auto [low_c, high_c] = domain_of(curve);
  const double from_c = std::max(low_c, sensor.temp_min_c);
  const double to_c = std::min(high_c, sensor.temp_max_c);
  const bool part = from_c < to_c && (from_c > sensor.temp_min_c || to_c < sensor.temp_max_c);
  if (part) return tabulate(curve, from_c, to_c, grid_over(from_c, to_c, points, kLeastGrain_c));
  const double grain = coarse_grain_c(sensor.temp_min_c, sensor.temp_max_c, points);
  return tabulate(curve, sensor.temp_min_c, sensor.temp_max_c,
                  grid_over(sensor.temp_min_c, sensor.temp_max_c, points, grain));
}

base::Result<Curve> table_of(const Curve& curve, const SensorCalibration& sensor, int points) {
  if (is_small_table(curve, points)) return curve;
  const std::string where(name_of(sensor.sensor));
  if (const auto status = check_evaluable(curve); !status) return base::bad_input(status.error().message, where);
  TableCurve table = table_over(curve, sensor, points);
  const double bound = table::largest_difference(table, curve, sensor.temp_min_c, sensor.temp_max_c);
  if (!std::isfinite(bound)) {
    return base::bad_input("no table can be proven to be near this curve, which is too steep; export the curve itself",
                           where);
  }
  // a table that stands for a table that stands for a curve
  const auto* original = std::get_if<TableCurve>(&curve);
  table.bound = bound + (original != nullptr ? original->bound.value_or(0.0) : 0.0);
  return table;
}

}  // namespace

base::Result<Calibration> table_form(const Calibration& calibration, int points) {
  if (points < kFewestTablePoints || points > kMostTablePoints) {
    return base::bad_input("a table has 2 to 256 points, not " + std::to_string(points), "points");
  }
  Calibration result = calibration;
  for (SensorCalibration& sensor : result.sensors) {
    auto bias = table_of(sensor.bias, sensor, points);
    if (!bias) return base::forward_error(bias);
    sensor.bias = *std::move(bias);
    if (!sensor.scale_ppm) continue;
    auto scale = table_of(*sensor.scale_ppm, sensor, points);
    if (!scale) return base::forward_error(scale);
    sensor.scale_ppm = *std::move(scale);
  }
  return result;
}

}  // namespace soak::calib
