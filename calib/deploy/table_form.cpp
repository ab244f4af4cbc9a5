// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/table_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "anfis/model/one_input.h"

namespace soak::calib {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- interval arithmetic ----

/// All numbers from low to high; low <= high. The operations give the range of the results, up to the rounding of
/// double precision.
struct Interval {
  double low = 0.0;
  double high = 0.0;

  /// Largest magnitude.
  [[nodiscard]] double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
};

Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
Interval operator+(Interval a, double b) { return {a.low + b, a.high + b}; }
Interval operator-(Interval a, double b) { return {a.low - b, a.high - b}; }
Interval operator*(double k, Interval a) {
  return k < 0.0 ? Interval{k * a.high, k * a.low} : Interval{k * a.low, k * a.high};
}
Interval operator*(Interval a, Interval b) {
  const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
  return {low, high};
}

/// Ranges that hold every value and every slope (per °C) of a curve over a stretch of temperature. Infinite or NaN
/// where no range can be given.
struct Enclosure {
  Interval value;
  Interval slope;
};

/// A stretch of temperature in °C on which a curve is smooth, and its enclosure on any part of the stretch.
struct Piece {
  double from_c = 0.0;
  double to_c = 0.0;
  std::function<Enclosure(Interval temp_c)> enclose;
};

// ---- enclosures of curves ----

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

/// Enclosure of a model in °C over a part of its input's range.
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

/// Enclosure of Σ_p c[p] d^p.
Enclosure enclose(const std::array<double, 4>& c, Interval d) {
  const Interval value = d * (d * (c[3] * d + c[2]) + c[1]) + c[0];
  const Interval slope = d * (3.0 * c[3] * d + 2.0 * c[2]) + c[1];
  return {value, slope};
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

/// The curve from from_c to to_c, held outside its own domain, in smooth pieces from left to right. Models must be such
/// that anfis::validate_curve() accepts.
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

// ---- the bound of a table ----

constexpr double kExcess = 1.01;
constexpr double kLeastPerSpan = 1e-9;
// Where they are used up the bound is still one, but may exceed the difference by more than 1 %.
constexpr int kMostHalvings = 200000;
// Samples per piece before the halving: the better the largest difference is known, the fewer stretches are halved.
constexpr int kSamples = 4;
// Rounding of double precision in some hundred operations.
constexpr double kRounding = 1e-13;

/// A stretch on which both the curve and the table are smooth, the table being offset + slope (T − at_c).
struct Stretch {
  const Piece& curve;
  double at_c;
  double offset;
  double slope;
};

/// e = curve − table
Enclosure difference(const Stretch& stretch, Interval temp_c) {
  const Enclosure curve = stretch.curve.enclose(temp_c);
  const Interval table = stretch.slope * (temp_c - stretch.at_c) + stretch.offset;
  return {curve.value - table, curve.slope - stretch.slope};
}

double magnitude_at(const Stretch& stretch, double temp_c) {
  return difference(stretch, {temp_c, temp_c}).value.magnitude();
}

class BoundSearch {
 public:
  /// found: the largest |e| that samples have shown. enough: a bound that needs no halving.
  BoundSearch(double found, double enough) : found_(found), enough_(enough) {}

  /// A bound of |e| on a part of a stretch.
  double bound(const Stretch& stretch, Interval temp_c) {
    const double middle = 0.5 * (temp_c.low + temp_c.high);
    const double half_width = 0.5 * (temp_c.high - temp_c.low);
    const double at_middle = magnitude_at(stretch, middle);
    if (!std::isfinite(at_middle)) return kInfinity;
    found_ = std::max(found_, at_middle);
    const Enclosure e = difference(stretch, temp_c);
    const double mean_value = at_middle + half_width * e.slope.magnitude();
    const double own_range = e.value.magnitude();
    const double here = own_range < mean_value ? own_range : mean_value;
    const bool splits = temp_c.low < middle && middle < temp_c.high && halvings_ < kMostHalvings;
    if (here <= std::max(kExcess * found_, enough_) || !splits) return std::isnan(here) ? kInfinity : here;
    ++halvings_;
    const double left = bound(stretch, {temp_c.low, middle});
    const double right = bound(stretch, {middle, temp_c.high});
    return std::max(left, right);
  }

 private:
  double found_;
  double enough_;
  int halvings_ = 0;
};

double left_of(const Piece& curve, const Piece& table) { return std::max(curve.from_c, table.from_c); }
double right_of(const Piece& curve, const Piece& table) { return std::min(curve.to_c, table.to_c); }

/// Calls visit(curve's piece, table's piece) for every two that overlap.
template <class Visit>
void for_each_overlap(const std::vector<Piece>& curve, const std::vector<Piece>& table, Visit visit) {
  for (std::size_t i = 0, j = 0; i < curve.size() && j < table.size();) {
    if (left_of(curve[i], table[j]) < right_of(curve[i], table[j])) visit(curve[i], table[j]);
    curve[i].to_c < table[j].to_c ? ++i : ++j;
  }
}

Stretch stretch_of(const Piece& curve, const Piece& table) {
  const double at = left_of(curve, table);
  const Enclosure line = table.enclose({at, at});
  return {curve, at, line.value.low, line.slope.low};
}

/// A number that |table − curve| exceeds nowhere from from_c to to_c, and that it comes within 1 % of (or 1e-9 of the
/// table's span). Infinite if none can be given: where all strengths of a model's rules underflow.
///
/// Proof by halving [Moore, Kearfott, Cloud: Introduction to Interval Analysis, §6.4]: with E' a range of the slope of
/// the difference e over a stretch of half-width r about m, |e| <= |e(m)| + r max|E'|; likewise |e| is bounded by its
/// own range there. A stretch whose lesser bound exceeds the largest |e| found so far by more than 1 % is halved.
double largest_difference(const TableCurve& table, const Curve& curve, double from_c, double to_c) {
  const Curve other(table);
  const std::vector<Piece> of_curve = pieces_of(curve, from_c, to_c);
  const std::vector<Piece> of_table = pieces_of(other, from_c, to_c);
  const auto [least, largest] = std::ranges::minmax(table.values);
  double found = std::abs(evaluate(other, from_c) - evaluate(curve, from_c));
  for_each_overlap(of_curve, of_table, [&](const Piece& a, const Piece& b) {
    const Stretch stretch = stretch_of(a, b);
    const double left = left_of(a, b);
    const double width = right_of(a, b) - left;
    for (int i = 0; i <= kSamples; ++i) found = std::max(found, magnitude_at(stretch, left + width * i / kSamples));
  });
  double bound = found;
  BoundSearch search(found, kLeastPerSpan * (largest - least));
  for_each_overlap(of_curve, of_table, [&](const Piece& a, const Piece& b) {
    bound = std::max(bound, search.bound(stretch_of(a, b), {left_of(a, b), right_of(a, b)}));
  });
  return bound + kRounding * std::max(std::abs(least), std::abs(largest));
}

// ---- the table ----

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
  const double bound = largest_difference(table, curve, sensor.temp_min_c, sensor.temp_max_c);
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
