// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/cubic_refit.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/linear/dense_solve.h"

namespace soak::calib::exporting {
namespace {

constexpr double kLeastShareOfMedian = 1.0 / 3.0;

/// Half-width of the band at a temperature: linear between the table's points, held beyond them.
double ci95_at(const UncertaintyTable& table, double temp_c) {
  if (table.temp_c.empty()) return 0.0;
  const auto upper = std::upper_bound(table.temp_c.begin(), table.temp_c.end(), temp_c);
  if (upper == table.temp_c.begin()) return table.ci95.front();
  if (upper == table.temp_c.end()) return table.ci95.back();
  const auto i = static_cast<std::size_t>(upper - table.temp_c.begin());
  const double share = (temp_c - table.temp_c[i - 1]) / (table.temp_c[i] - table.temp_c[i - 1]);
  return table.ci95[i - 1] + share * (table.ci95[i] - table.ci95[i - 1]);
}

std::vector<double> values_of(const Curve& curve, const std::vector<double>& temps_c) {
  std::vector<double> values(temps_c.size());
  evaluate(curve, temps_c, values);
  return values;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Σ a_k (α d + β)^k as coefficients of d, by Horner's scheme on polynomials.
Cubic with_argument(const Eigen::Vector4d& a, double alpha, double beta) {
  Cubic result{};
  for (int k = 3; k >= 0; --k) {
    for (std::size_t i = 3; i > 0; --i) result[i] = beta * result[i] + alpha * result[i - 1];
    result[0] = beta * result[0] + a[k];
  }
  return result;
}

std::optional<std::array<double, 2>> extremes(const std::optional<Curve>& curve, const std::vector<double>& temps_c) {
  if (!curve) return std::nullopt;
  const std::vector<double> values = values_of(*curve, temps_c);
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return std::array<double, 2>{*least, *greatest};
}

/// Refuses sensors that the target would correct by a thermometer that they were not calibrated over.
base::Status check_thermometer(const std::array<const SensorCalibration*, 3>& axes, std::string_view target,
                               const std::string& unit) {
  const auto* const own = std::ranges::find_if(axes, &SensorCalibration::own_thermometer);
  if (own == axes.end()) return {};
  return base::bad_input(
      fmt::format("{} was calibrated over its own thermometer, but {} reads one temperature for all three {}s: import "
                  "the recording without the column of that thermometer (or as temp_c, if it is the one that the "
                  "autopilot reads), then fit and export again; or deploy the whole model (--format blob or c)",
                  name_of((*own)->sensor), target, is_gyro((*own)->sensor) ? "gyro" : "accelerometer"),
      fmt::format("unit {}", unit));
}

}  // namespace

std::vector<double> grid_of(TempRange range) {
  std::vector<double> temps_c(kGridPoints);
  const double step_c = (range.max_c - range.min_c) / static_cast<double>(kGridPoints - 1);
  for (std::size_t i = 0; i < kGridPoints; ++i) temps_c[i] = range.min_c + static_cast<double>(i) * step_c;
  temps_c.back() = range.max_c;
  return temps_c;
}

base::Result<std::vector<const SensorCalibration*>> three_axes(const Calibration& calibration, bool gyro,
                                                               std::string_view target) {
  std::array<const SensorCalibration*, 3> axes{};
  for (const SensorCalibration& sensor : calibration.sensors) {
    if (is_gyro(sensor.sensor) == gyro) axes[axis_of(sensor.sensor)] = &sensor;
  }
  if (std::count(axes.begin(), axes.end(), nullptr) == 3) return std::vector<const SensorCalibration*>();
  const auto missing = static_cast<std::size_t>(std::find(axes.begin(), axes.end(), nullptr) - axes.begin());
  if (missing == 3) {
    if (auto status = check_thermometer(axes, target, calibration.unit); !status) return base::forward_error(status);
    return std::vector<const SensorCalibration*>(axes.begin(), axes.end());
  }
  return base::bad_input(
      fmt::format("the model has no {}, but {} corrects the three axes together: fit runs that contain all three",
                  kSensorNames[missing + (gyro ? 0 : 3)], target),
      fmt::format("unit {}", calibration.unit));
}

base::Result<TempRange> common_range(std::span<const SensorCalibration* const> sensors) {
  TempRange range{sensors.front()->temp_min_c, sensors.front()->temp_max_c};
  std::string ranges;
  for (const SensorCalibration* sensor : sensors) {
    range.min_c = std::max(range.min_c, sensor->temp_min_c);
    range.max_c = std::min(range.max_c, sensor->temp_max_c);
    ranges += fmt::format("{}{} {:g} to {:g}", ranges.empty() ? "" : ", ", name_of(sensor->sensor), sensor->temp_min_c,
                          sensor->temp_max_c);
  }
  range = {static_cast<double>(static_cast<float>(range.min_c)), static_cast<double>(static_cast<float>(range.max_c))};
  if (range.min_c < range.max_c) return range;
  return base::bad_input(
      "the parameters need one valid range for all these sensors, but the ranges of the sensors do not overlap (" +
      ranges + " degC): fit runs that cover the same temperatures for all of them");
}

std::vector<double> fit_weights(const UncertaintyTable& uncertainty, std::span<const double> temps_c) {
  std::vector<double> widths;
  for (const double temp_c : temps_c) widths.push_back(ci95_at(uncertainty, temp_c));
  const double least = kLeastShareOfMedian * median_of(widths);
  std::vector<double> weights(temps_c.size(), 1.0);
  if (!(least > 0.0)) return weights;
  // w = 1/u²
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = 1.0 / std::pow(std::max(widths[i], least), 2.0);
  return weights;
}

Cubic best_cubic(const SensorCalibration& sensor, TempRange range, double reference_c) {
  const std::vector<double> temps_c = grid_of(range);
  const std::vector<double> bias = values_of(sensor.bias, temps_c);
  const std::vector<double> weights = fit_weights(sensor.bias_uncertainty, temps_c);
  const double middle = 0.5 * (range.min_c + range.max_c);
  const double half = 0.5 * (range.max_c - range.min_c);
  // sqrt(w_i) Σ_k a_k s_i^k ≈ sqrt(w_i) bias_i with s from −1 to 1: about a reference far from the range, the columns
  // would be nearly parallel.
  Eigen::MatrixX4d design(static_cast<Eigen::Index>(temps_c.size()), 4);
  Eigen::VectorXd target(design.rows());
  for (Eigen::Index i = 0; i < design.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double s = (temps_c[at] - middle) / half;
    const double root = std::sqrt(weights[at]);
    design.row(i) << root, root * s, root * s * s, root * s * s * s;
    target[i] = root * bias[at];
  }
  const Eigen::Vector4d a = base::solve_pivoted_qr(design, target);
  // s = (d + reference − middle) / half
  return with_argument(a, 1.0 / half, (reference_c - middle) / half);
}

CubicLoss loss_of(const SensorCalibration& sensor, TempRange range, double reference_c,
                  const std::function<float(float)>& correction) {
  const std::vector<double> temps_c = grid_of(range);
  const std::vector<double> bias = values_of(sensor.bias, temps_c);
  CubicLoss loss{.sensor = sensor.sensor,
                 .temp_min_c = range.min_c,
                 .temp_max_c = range.max_c,
                 .reference_c = reference_c,
                 .scale_ppm = extremes(sensor.scale_ppm, temps_c)};
  double squares = 0.0;
  std::size_t beyond = 0;
  double before = 0.0;
  for (std::size_t i = 0; i < temps_c.size(); ++i) {
    const auto corrected = static_cast<double>(correction(static_cast<float>(temps_c[i])));
    const double difference = std::abs(corrected - bias[i]);
    const double ci95 = ci95_at(sensor.bias_uncertainty, temps_c[i]);
    squares += difference * difference;
    beyond += difference > ci95 ? 1 : 0;
    if (i == 0 || difference > loss.worst) {
      loss.worst = difference;
      loss.worst_temp_c = temps_c[i];
      loss.ci95_at_worst = ci95;
    }
    if (i > 0) {
      const double slope = std::abs(corrected - before) / (temps_c[i] - temps_c[i - 1]);
      loss.steepest_per_c = std::max(loss.steepest_per_c, slope);
    }
    before = corrected;
  }
  loss.rms = std::sqrt(squares / static_cast<double>(temps_c.size()));
  loss.beyond_ci95 = static_cast<double>(beyond) / static_cast<double>(temps_c.size());
  return loss;
}

}  // namespace soak::calib::exporting
