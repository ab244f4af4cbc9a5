// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/unit/thermal_curve.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

constexpr double kBoltzmann_evpk = 8.617333262e-5;  // CODATA 2018
constexpr double kGridStep_c = 0.25;
constexpr double kReference_c = 25.0;

double value_of(const ThermalCurve::Arctan& term, double temp_c) {
  return term.gain * std::atan((temp_c - term.centre_c) / term.width_c);
}

double value_of(const ThermalCurve::Activated& term, double temp_c) {
  const double inverse_k = 1.0 / (temp_c + base::kZeroCelsius_k) - 1.0 / (term.hot_c + base::kZeroCelsius_k);
  return term.gain * std::exp(-term.energy_ev / kBoltzmann_evpk * inverse_k);
}

double value_of(const ThermalCurve::Feature& feature, double temp_c) {
  const double z = (temp_c - feature.centre_c) / feature.sigma_c;
  return feature.height * std::exp(-0.5 * z * z);
}

/// `term`, which is monotonic, with the gain that makes it change by `change` between the ends of the range.
template <class Term>
Term with_change(Term term, const CurveShape& shape, double change) {
  term.gain = 1.0;
  term.gain = change / (value_of(term, shape.hot_c) - value_of(term, shape.cold_c));
  return term;
}

}  // namespace

double ThermalCurve::smooth(double temp_c) const {
  return value_of(arctans_[0], temp_c) + value_of(arctans_[1], temp_c) + value_of(activated_, temp_c);
}

double ThermalCurve::local(double temp_c) const {
  double sum = 0.0;
  for (const Feature& feature : features_) sum += value_of(feature, temp_c);
  return sum;
}

// The span of (k · smooth + local) is convex in k, below `span` at k = 0 and above it at the upper bound chosen here,
// so that bisection finds the one crossing.
void ThermalCurve::scale_smooth_to_span(const CurveShape& shape, double span) {
  std::vector<double> smooth_values;
  std::vector<double> local_values;
  for (const double temp_c : dense_grid_c(shape)) {
    smooth_values.push_back(smooth(temp_c));
    local_values.push_back(local(temp_c));
  }
  const auto span_at = [&](double k) {
    std::vector<double> sum(smooth_values.size());
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = k * smooth_values[i] + local_values[i];
    return span_of(sum);
  };
  double low = 0.0;
  double high = (span + span_of(local_values)) / span_of(smooth_values);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (span_at(middle) < span ? low : high) = middle;
  }
  for (Arctan& term : arctans_) term.gain *= high;
  activated_.gain *= high;
}

ThermalCurve ThermalCurve::draw(const CurveShape& shape, const CurveMagnitudes& magnitudes, base::Random& random) {
  const double span = drawn_from(random, magnitudes.span);
  const double at_reference = drawn_within(random, magnitudes.at_25c_half_width);

  ThermalCurve curve;
  for (std::size_t i = 0; i < curve.arctans_.size(); ++i) {
    Arctan term;
    term.centre_c = drawn_from(random, shape.arctan_centre_c);
    term.width_c = drawn_from(random, shape.arctan_width_c);
    const double weight = i == 0 ? drawn_sign(random) : drawn_sign(random) * drawn_from(random, shape.other_weight);
    curve.arctans_[i] = with_change(term, shape, weight);
  }
  Activated term;
  term.hot_c = shape.hot_c;
  term.energy_ev = drawn_from(random, shape.activation_energy_ev);
  curve.activated_ = with_change(term, shape, drawn_sign(random) * drawn_from(random, shape.other_weight));

  const int count = drawn_count(random, magnitudes.feature_count);
  for (int i = 0; i < count; ++i) {
    Feature feature;
    feature.height = drawn_sign(random) * drawn_from(random, magnitudes.feature_height);
    feature.centre_c = random.uniform(shape.cold_c + shape.feature_margin_c, shape.hot_c - shape.feature_margin_c);
    feature.sigma_c = drawn_from(random, magnitudes.feature_sigma_c);
    curve.features_.push_back(feature);
  }
  curve.scale_smooth_to_span(shape, span);
  curve.offset_ = at_reference - curve.at(kReference_c);
  return curve;
}

std::vector<double> dense_grid_c(const CurveShape& shape) {
  const auto steps = static_cast<std::size_t>(std::floor((shape.hot_c - shape.cold_c) / kGridStep_c + 1e-9));
  std::vector<double> grid_c(steps + 1);
  for (std::size_t i = 0; i <= steps; ++i) grid_c[i] = shape.cold_c + kGridStep_c * static_cast<double>(i);
  return grid_c;
}

double span_of(const std::vector<double>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return *greatest - *least;
}

}  // namespace soak::hal::sim
