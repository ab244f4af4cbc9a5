// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "anfis/model/one_input.h"
#include "calib/deploy/detail/sections.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

bool is_temperature(double temp_c) {
  return temp_c >= static_cast<double>(SOAK_TEMP_LOWEST) && temp_c <= static_cast<double>(SOAK_TEMP_HIGHEST);
}

double centre_c(const anfis::Model& model, const anfis::CurveRule& rule) {
  return model.inputs[0].scale.unscaled(rule.centre);
}

/// The least float32 number that is not below a number.
double rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  const bool below = static_cast<double>(nearest) < value;
  return static_cast<double>(below ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest);
}

base::Status check_form(const anfis::Model& model, const std::string& where) {
  if (auto status = anfis::validate(model); !status) {
    return base::bad_input("the fuzzy model is not usable: " + status.error().message,
                           where + ' ' + status.error().where);
  }
  if (auto status = anfis::validate_curve(model); !status) {
    return base::bad_input("the file cannot carry this fuzzy model: " + status.error().message,
                           where + ' ' + status.error().where);
  }
  if (model.rules.size() > SOAK_MAX_RULES) {
    return base::bad_input("the model has " + std::to_string(model.rules.size()) + " rules; the file carries at most " +
                               std::to_string(SOAK_MAX_RULES),
                           where);
  }
  for (const anfis::CurveRule& rule : anfis::curve_rules(model)) {
    if (std::abs(centre_c(model, rule)) > static_cast<double>(SOAK_MAX_CENTRE)) {
      return base::bad_input("a rule's centre lies beyond 10,000 °C; fit with fewer rules", where);
    }
  }
  return {};
}

base::Status check_form(const SplineCurve& spline, const std::string& where) {
  if (spline.coefficients.empty() || spline.coefficients.size() > SOAK_MAX_PIECES ||
      spline.knots_c.size() != spline.coefficients.size() + 1) {
    return base::bad_input("a spline needs 1 to " + std::to_string(SOAK_MAX_PIECES) +
                               " pieces and one knot more, not " + std::to_string(spline.coefficients.size()) +
                               " pieces and " + std::to_string(spline.knots_c.size()) + " knots",
                           where);
  }
  if (!std::all_of(spline.knots_c.begin(), spline.knots_c.end(), is_temperature)) {
    return base::bad_input("the knots must lie within -273.15 ... 1000 °C", where);
  }
  return {};
}

base::Status check_form(const TableCurve& table, const std::string& where) {
  if (table.values.empty() || table.values.size() > SOAK_MAX_POINTS) {
    return base::bad_input(
        "a table needs 1 to " + std::to_string(SOAK_MAX_POINTS) + " points, not " + std::to_string(table.values.size()),
        where);
  }
  if (soak_table_fits(static_cast<float>(table.first_c), static_cast<float>(table.step_c),
                      static_cast<std::uint32_t>(table.values.size())) == 0) {
    return base::bad_input("the step must be positive and all points within -273.15 ... 1000 °C, in float32 too",
                           where);
  }
  if (table.bound && !(*table.bound >= 0.0 && fits_float(rounded_up(*table.bound)))) {
    return base::bad_input("the bound of a table must be a finite number that is not negative", where);
  }
  return {};
}

void write_scale(base::ByteWriter& out, const OutputScale& scale) {
  write_floats(out, {scale.centre, scale.half_range});
}

/// Parameters of one rule about its own centre in °C: c, c', w, s, v, g.
std::array<double, 6> rule_in_celsius(const anfis::Model& model, const anfis::CurveRule& rule,
                                      const OutputScale& scale) {
  const double input_half_range = model.inputs[0].scale.half_range;
  const double centre = centre_c(model, rule);
  const auto rounded = static_cast<double>(static_cast<float>(centre));
  // C + H r = output.centre + output.half_range f  =>  r = (output.centre - C + output.half_range f) / H
  const double at_centre = rule.gain * rule.centre + rule.offset;
  const double value = (model.output.centre - scale.centre + model.output.half_range * at_centre) / scale.half_range;
  const double gain = model.output.half_range * rule.gain / (scale.half_range * input_half_range);
  return {rounded, centre - rounded, rule.width * input_half_range, rule.slope, value, gain};
}

base::Result<Section> section_of(base::ByteWriter out, const anfis::Model& model, const OutputScale& scale,
                                 const std::string& where) {
  const bool bells = anfis::curve_shape(model) == anfis::Shape::bell;
  out.write(static_cast<std::uint8_t>(bells ? 0 : 1));
  out.write(static_cast<std::uint8_t>(model.order));
  out.write(static_cast<std::uint16_t>(model.rules.size()));
  out.write(std::uint16_t{0});
  write_floats(out, {model.inputs[0].min, model.inputs[0].max});
  write_scale(out, scale);
  for (const anfis::CurveRule& rule : anfis::curve_rules(model)) {
    const auto numbers = rule_in_celsius(model, rule, scale);
    const bool positive = static_cast<float>(numbers[2]) > 0.0F && (!bells || static_cast<float>(numbers[3]) > 0.0F);
    if (!std::all_of(numbers.begin(), numbers.end(), fits_float) || !positive) {
      return base::bad_input("a rule's numbers are too large or too small for float32; fit with fewer rules", where);
    }
    write_floats(out, {numbers.begin(), numbers.end()});
  }
  return Section{SOAK_SECTION_FIS, true, out.take()};
}

/// Piece `c` about `knot`, rewritten for s = -1..1 over left..right: Taylor coefficients about the middle.
std::array<double, 4> about_middle(const std::array<double, 4>& c, double knot, double left, double right) {
  const double d = (left + right) / 2.0 - knot;
  const double h = (right - left) / 2.0;
  return {c[0] + d * (c[1] + d * (c[2] + d * c[3])), h * (c[1] + d * (2.0 * c[2] + d * 3.0 * c[3])),
          h * h * (c[2] + 3.0 * c[3] * d), h * h * h * c[3]};
}

base::Result<Section> section_of(base::ByteWriter out, const SplineCurve& spline, const OutputScale& scale,
                                 const std::string& where) {
  const std::size_t pieces = spline.coefficients.size();
  out.write(static_cast<std::uint16_t>(pieces));
  write_scale(out, scale);
  write_floats(out, spline.knots_c);
  for (std::size_t i = 0; i < pieces; ++i) {
    const auto left = static_cast<double>(static_cast<float>(spline.knots_c[i]));
    const auto right = static_cast<double>(static_cast<float>(spline.knots_c[i + 1]));
    if (!(left < right)) return base::bad_input("the knots must rise, by more than float32 resolves", where);
    auto q = about_middle(spline.coefficients[i], spline.knots_c[i], left, right);
    q[0] -= scale.centre;
    for (double& number : q) number /= scale.half_range;
    if (!std::all_of(q.begin(), q.end(), fits_float)) {
      return base::bad_input("a spline coefficient is not a finite float32 number", where);
    }
    write_floats(out, {q.begin(), q.end()});
  }
  return Section{SOAK_SECTION_SPLINE, true, out.take()};
}

base::Result<Section> section_of(base::ByteWriter out, const TableCurve& table, const OutputScale& scale,
                                 const std::string& where) {
  std::vector<double> values = table.values;
  for (double& value : values) value = (value - scale.centre) / scale.half_range;
  if (!fit_float(values)) return base::bad_input("a table value is not a finite float32 number", where);
  out.write(static_cast<std::uint16_t>(values.size()));
  write_scale(out, scale);
  write_floats(out, {table.first_c, table.step_c});
  write_floats(out, values);
  return Section{SOAK_SECTION_TABLE, true, out.take()};
}

anfis::CurveRule read_rule(const std::uint8_t* payload, anfis::Shape shape, const anfis::Scale& input) {
  const auto n = read_floats(payload, 6);
  anfis::CurveRule rule;
  rule.centre = (n[0] + n[1] - input.centre) / input.half_range;
  rule.width = n[2] / input.half_range;
  rule.slope = shape == anfis::Shape::bell ? n[3] : 0.0;
  rule.gain = n[5] * input.half_range;
  rule.offset = n[4] - rule.gain * rule.centre;
  return rule;
}

anfis::Model read_model(const std::uint8_t* payload) {
  const auto numbers = read_floats(payload + 8, 4);
  const double min = numbers[0];
  const double max = numbers[1];
  const anfis::Scale scale{(min + max) / 2.0, max > min ? (max - min) / 2.0 : 1.0};
  const anfis::Shape shape = payload[2] == 0 ? anfis::Shape::bell : anfis::Shape::gaussian;
  std::vector<anfis::CurveRule> rules;
  const std::size_t count = soak_u16(payload + 4);
  for (std::size_t i = 0; i < count; ++i) rules.push_back(read_rule(payload + 24 + 24 * i, shape, scale));
  anfis::Model model = anfis::curve_model(shape, rules);
  model.order = payload[3];
  model.inputs[0].scale = scale;
  model.inputs[0].min = min;
  model.inputs[0].max = max;
  model.output = {numbers[2], numbers[3]};
  return model;
}

SplineCurve read_spline(const std::uint8_t* payload) {
  const std::size_t pieces = soak_u16(payload + 2);
  const auto scale = read_floats(payload + 4, 2);
  SplineCurve spline;
  spline.knots_c = read_floats(payload + 12, pieces + 1);
  for (std::size_t i = 0; i < pieces; ++i) {
    const auto q = read_floats(payload + 16 + 4 * pieces + 16 * i, 4);
    const double h = (spline.knots_c[i + 1] - spline.knots_c[i]) / 2.0;
    // s = (T - knot)/h - 1: Taylor coefficients about s = -1
    const std::array<double, 4> about_left = {q[0] - q[1] + q[2] - q[3], (q[1] - 2.0 * q[2] + 3.0 * q[3]) / h,
                                              (q[2] - 3.0 * q[3]) / (h * h), q[3] / (h * h * h)};
    std::array<double, 4> c{};
    for (std::size_t p = 0; p < 4; ++p) c[p] = scale[1] * about_left[p];
    c[0] += scale[0];
    spline.coefficients.push_back(c);
  }
  return spline;
}

TableCurve read_table(const std::uint8_t* payload) {
  const auto numbers = read_floats(payload + 4, 4);
  TableCurve table{numbers[2], numbers[3], read_floats(payload + 20, soak_u16(payload + 2)), std::nullopt};
  for (double& value : table.values) value = numbers[0] + numbers[1] * value;
  return table;
}

}  // namespace

base::Status check_curve(const Curve& curve, const std::string& where) {
  return std::visit([&](const auto& kind) { return check_form(kind, where); }, curve);
}

base::Result<Section> curve_section(Sensor sensor, Quantity quantity, const Curve& curve, const OutputScale& scale) {
  return std::visit(
      [&](const auto& kind) { return section_of(payload_of(sensor, quantity), kind, scale, place(sensor, quantity)); },
      curve);
}

std::optional<Section> table_bound_section(Sensor sensor, Quantity quantity, const Curve& curve) {
  const auto* table = std::get_if<TableCurve>(&curve);
  if (table == nullptr || !table->bound) return std::nullopt;
  base::ByteWriter out = payload_of(sensor, quantity);
  out.write(std::uint16_t{0});
  write_floats(out, {rounded_up(*table->bound)});
  return Section{SOAK_SECTION_TABLE_BOUND, false, out.take()};
}

Curve read_curve(std::uint32_t type, const std::uint8_t* payload) {
  if (type == SOAK_SECTION_FIS) return read_model(payload);
  if (type == SOAK_SECTION_SPLINE) return read_spline(payload);
  return read_table(payload);
}

}  // namespace soak::calib::file
