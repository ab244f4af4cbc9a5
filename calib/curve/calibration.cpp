// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/calibration.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace soak::calib {
namespace {

double value_at(const anfis::Model& model, double temp_c) {
  return anfis::evaluate(model, std::clamp(temp_c, model.inputs[0].min, model.inputs[0].max));
}

double value_at(const SplineCurve& spline, double temp_c) {
  const double t = std::clamp(temp_c, spline.knots_c.front(), spline.knots_c.back());
  const auto after = std::upper_bound(spline.knots_c.begin() + 1, spline.knots_c.end() - 1, t);
  const auto piece = static_cast<std::size_t>(after - spline.knots_c.begin()) - 1;
  const auto& c = spline.coefficients[piece];
  const double d = t - spline.knots_c[piece];
  return c[0] + d * (c[1] + d * (c[2] + d * c[3]));
}

double value_at(const TableCurve& table, double temp_c) {
  if (table.values.size() == 1) return table.values.front();
  const auto last = static_cast<double>(table.values.size() - 1);
  const double steps = std::clamp((temp_c - table.first_c) / table.step_c, 0.0, last);
  const auto below = std::min(static_cast<std::size_t>(steps), table.values.size() - 2);
  const double fraction = steps - static_cast<double>(below);
  return table.values[below] + fraction * (table.values[below + 1] - table.values[below]);
}

void values_at(const anfis::Model& model, std::span<const double> temp_c, std::span<double> values) {
  const anfis::Input& input = model.inputs[0];
  std::vector<double> clamped;
  for (const double t : temp_c) clamped.push_back(std::clamp(t, input.min, input.max));
  anfis::evaluate(model, clamped, values);
}

template <class Kind>
void values_at(const Kind& kind, std::span<const double> temp_c, std::span<double> values) {
  std::ranges::transform(temp_c, values.begin(), [&](double t) { return value_at(kind, t); });
}

std::array<double, 2> domain(const anfis::Model& model) { return {model.inputs[0].min, model.inputs[0].max}; }

std::array<double, 2> domain(const SplineCurve& spline) { return {spline.knots_c.front(), spline.knots_c.back()}; }

std::array<double, 2> domain(const TableCurve& table) {
  return {table.first_c, table.first_c + table.step_c * static_cast<double>(table.values.size() - 1)};
}

}  // namespace

double evaluate(const Curve& curve, double temp_c) {
  return std::visit([&](const auto& kind) { return value_at(kind, temp_c); }, curve);
}

void evaluate(const Curve& curve, std::span<const double> temp_c, std::span<double> values) {
  std::visit([&](const auto& kind) { values_at(kind, temp_c, values); }, curve);
}

std::array<double, 2> domain_of(const Curve& curve) {
  return std::visit([](const auto& kind) { return domain(kind); }, curve);
}

std::optional<double> measured_scale_ppm(const SensorCalibration& sensor, double temp_c) {
  if (!sensor.scale_ppm) return std::nullopt;
  const auto [low_c, high_c] = domain_of(*sensor.scale_ppm);
  if (temp_c < low_c || temp_c > high_c) return std::nullopt;
  return evaluate(*sensor.scale_ppm, temp_c);
}

}  // namespace soak::calib
