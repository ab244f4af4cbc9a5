// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/enclosure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "anfis/model/one_input.h"

namespace soak::calib::table {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What one rule contributes over a stretch of the scaled temperature u.
struct RuleRange {
  Interval strength;   ///< μ
  Interval log_slope;  ///< λ = d ln μ / du
  Interval value;      ///< f = gain·u + offset
};

double strength(anfis::Shape shape, const anfis::CurveRule& rule, double distance) {
  const double z = std::abs(distance) / rule.width;
  return shape == anfis::Shape::bell ? 1.0 / (1.0 + std::pow(z, 2.0 * rule.slope)) : std::exp(-z * z / 2.0);
}

/// Least and largest |λ| of a bell over the distances near <= |d| <= far: λ = −(2b/d) (1 − μ).
Interval bell_log_slope(const anfis::CurveRule& rule, double near, double far) {
  const auto tail = [&](double distance) { return 1.0 - strength(anfis::Shape::bell, rule, distance); };
  if (near > 0.0) return 2.0 * rule.slope * Interval{tail(near) / far, tail(far) / near};
  if (2.0 * rule.slope < 1.0) return {0.0, kInfinity};
  // (1 − μ)/|d| <= |d|^(2b−1) / a^(2b), which grows with |d|
  return {0.0, 2.0 * rule.slope * std::pow(far / rule.width, 2.0 * rule.slope) / far};
}

/// Range of λ over the distances d.
Interval log_slope(anfis::Shape shape, const anfis::CurveRule& rule, Interval d) {
  if (shape == anfis::Shape::gaussian) return (-1.0 / (rule.width * rule.width)) * d;
  if (d.low >= 0.0) return -1.0 * bell_log_slope(rule, d.low, d.high);
  if (d.high <= 0.0) return bell_log_slope(rule, -d.high, -d.low);
  return {-bell_log_slope(rule, 0.0, d.high).high, bell_log_slope(rule, 0.0, -d.low).high};
}

RuleRange rule_range(anfis::Shape shape, const anfis::CurveRule& rule, Interval u) {
  const Interval d = u - rule.centre;
  const double at_low = strength(shape, rule, d.low);
  const double at_high = strength(shape, rule, d.high);
  const bool holds_centre = d.low <= 0.0 && d.high >= 0.0;
  return {{std::min(at_low, at_high), holds_centre ? 1.0 : std::max(at_low, at_high)},
          log_slope(shape, rule, d),
          rule.gain * u + rule.offset};
}

/// Ranges of w_i = μ_i / (μ_i + Σ_{j≠i} μ_j), which grow with μ_i and fall with the others.
std::vector<Interval> weights(const std::vector<RuleRange>& rules) {
  Interval sum;
  for (const RuleRange& rule : rules) sum = sum + rule.strength;
  std::vector<Interval> result;
  for (const RuleRange& rule : rules) {
    const Interval own = rule.strength;
    result.push_back({own.low / (own.low + sum.high - own.high), own.high / (own.high + sum.low - own.low)});
  }
  return result;
}

Enclosure constant(double value) { return {{value, value}, {0.0, 0.0}}; }

void add_inner(const anfis::Model& model, std::vector<Piece>& pieces) {
  pieces.push_back({model.inputs[0].min, model.inputs[0].max, [&model](Interval t) { return enclose(model, t); }});
}

void add_inner(const SplineCurve& spline, std::vector<Piece>& pieces) {
  for (std::size_t i = 0; i < spline.coefficients.size(); ++i) {
    const double knot = spline.knots_c[i];
    pieces.push_back({knot, spline.knots_c[i + 1],
                      [&c = spline.coefficients[i], knot](Interval t) { return enclose(c, t - knot); }});
  }
}

void add_inner(const TableCurve& table, std::vector<Piece>& pieces) {
  for (std::size_t i = 0; i + 1 < table.values.size(); ++i) {
    const double left = table.first_c + table.step_c * static_cast<double>(i);
    const std::array<double, 4> line = {table.values[i], (table.values[i + 1] - table.values[i]) / table.step_c, 0.0,
                                        0.0};
    pieces.push_back({left, left + table.step_c, [line, left](Interval t) { return enclose(line, t - left); }});
  }
}

}  // namespace

Enclosure enclose(const std::array<double, 4>& c, Interval d) {
  const Interval value = d * (d * (c[3] * d + c[2]) + c[1]) + c[0];
  const Interval slope = d * (3.0 * c[3] * d + 2.0 * c[2]) + c[1];
  return {value, slope};
}

Enclosure enclose(const anfis::Model& model, Interval temp_c) {
  const anfis::Scale& scale = model.inputs[0].scale;
  const Interval u = {scale.scaled(temp_c.low), scale.scaled(temp_c.high)};
  const auto curve_rules = anfis::curve_rules(model);
  std::vector<RuleRange> rules;
  for (const anfis::CurveRule& rule : curve_rules) rules.push_back(rule_range(anfis::curve_shape(model), rule, u));
  const std::vector<Interval> w = weights(rules);
  // Σ w_i = 1: about any number m, Σ w_i f_i = m + Σ w_i (f_i − m), and a near m leaves the ranges narrow
  const double middle = anfis::evaluate(model, 0.5 * (temp_c.low + temp_c.high));
  const double m = model.output.scaled(middle);
  Interval value{m, m};
  for (std::size_t i = 0; i < rules.size(); ++i) value = value + w[i] * (rules[i].value - m);
  // d/du Σ w_i f_i = Σ w_i g_i + Σ w_i λ_i (f_i − Σ_j w_j f_j)
  Interval slope;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    slope = slope + curve_rules[i].gain * w[i] + w[i] * (rules[i].log_slope * (rules[i].value - value));
  }
  return {model.output.half_range * value + model.output.centre, (model.output.half_range / scale.half_range) * slope};
}

std::vector<Piece> pieces_of(const Curve& curve, double from_c, double to_c) {
  const auto [low_c, high_c] = domain_of(curve);
  const auto held = [&](double at) { return [value = evaluate(curve, at)](Interval) { return constant(value); }; };
  std::vector<Piece> all;
  all.push_back({from_c, low_c, held(low_c)});
  std::visit([&](const auto& kind) { add_inner(kind, all); }, curve);
  all.push_back({high_c, to_c, held(high_c)});
  std::vector<Piece> pieces;
  for (Piece& piece : all) {
    piece.from_c = std::max(piece.from_c, from_c);
    piece.to_c = std::min(piece.to_c, to_c);
    if (piece.from_c < piece.to_c) pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace soak::calib::table
