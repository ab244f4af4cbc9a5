// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/bump_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <variant>

namespace soak::calib {
namespace {

constexpr const char* kBump = "narrow_bump";
/// Largest difference of a piece from the sum, over the span of the sum.
constexpr double kPieceTolerance = 1e-5;
/// Halvings of a first piece: of 128 of these, more than any family has, come the 1024 that a file holds.
constexpr int kMostHalvings = 3;
constexpr int kFirstPieces = 24;
constexpr double kSameKnot_c = 1e-3;

using Value = std::function<double(double temp_c)>;

/// The cubic through the values at both ends and at a third and two thirds of the way, as powers of the distance from
/// the left end.
std::array<double, 4> cubic_through(const Value& value, double left, double right) {
  const double h = (right - left) / 3.0;
  const double y0 = value(left);
  // Newton's forward differences.
  const double d1 = value(left + h) - y0;
  const double d2 = value(left + 2.0 * h) - 2.0 * (y0 + d1) + y0;
  const double d3 = value(right) - y0 - 3.0 * d1 - 3.0 * d2;
  return {y0, (d1 - d2 / 2.0 + d3 / 3.0) / h, (d2 - d3) / (2.0 * h * h), d3 / (6.0 * h * h * h)};
}

double value_of(const std::array<double, 4>& c, double d) { return c[0] + d * (c[1] + d * (c[2] + d * c[3])); }

/// Appends pieces over left..right, halved until they are near enough.
void add_pieces(const Value& value, double left, double right, double tolerance, int halvings, SplineCurve& spline) {
  const std::array<double, 4> cubic = cubic_through(value, left, right);
  // Between its four points an interpolation is furthest off about here.
  constexpr std::array<double, 3> kBetween = {0.13, 0.5, 0.87};
  const bool near = std::ranges::all_of(kBetween, [&](double share) {
    const double d = share * (right - left);
    return std::abs(value_of(cubic, d) - value(left + d)) <= tolerance;
  });
  if (!near && halvings > 0) {
    const double middle = 0.5 * (left + right);
    add_pieces(value, left, middle, tolerance, halvings - 1, spline);
    return add_pieces(value, middle, right, tolerance, halvings - 1, spline);
  }
  spline.knots_c.push_back(left);
  spline.coefficients.push_back(cubic);
}

/// Where pieces begin and end before any is halved: where the curve is not smooth, and about the bump.
std::vector<double> first_knots(const Curve& curve, const CurveBump& bump) {
  const auto [low_c, high_c] = domain_of(curve);
  std::vector<double> knots = {low_c, high_c};
  if (const auto* spline = std::get_if<SplineCurve>(&curve)) {
    knots = spline->knots_c;
  } else if (const auto* table = std::get_if<TableCurve>(&curve)) {
    for (std::size_t k = 0; k < table->values.size(); ++k) {
      knots.push_back(table->first_c + table->step_c * static_cast<double>(k));
    }
  } else {
    for (int k = 1; k < kFirstPieces; ++k) knots.push_back(low_c + (high_c - low_c) * k / kFirstPieces);
  }
  for (const double widths : {-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0}) {
    const double knot_c = bump.centre_c + widths * bump.width_c;
    if (knot_c > low_c && knot_c < high_c) knots.push_back(knot_c);
  }
  std::ranges::sort(knots);
  const auto near = [](double a, double b) { return b - a < kSameKnot_c; };
  knots.erase(std::unique(knots.begin(), knots.end(), near), knots.end());
  // What was dropped may have been the end.
  knots.back() = high_c;
  return knots;
}

}  // namespace

double CurveBump::shape(double temp_c) const {
  const double off = (temp_c - centre_c) / width_c;
  return 1.0 / (1.0 + off * off);
}

double CurveBump::error_at(double temp_c) const {
  const double off = (temp_c - centre_c) / width_c;
  const double flank = 2.0 * height * std::pow(shape(temp_c), 2) * off / width_c;  // against the centre
  const Eigen::Vector3d slope(shape(temp_c), flank, flank * off);
  return std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
}

std::optional<CurveBump> bump_of(const std::vector<ModelTerm>& terms, Sensor sensor) {
  const auto term = std::ranges::find(terms, kBump, &ModelTerm::name);
  if (term == terms.end()) return std::nullopt;
  const TermPart* part = term->part_of(sensor);
  if (part == nullptr) return std::nullopt;
  const auto height = part->value("height");
  const auto centre_c = part->value("centre_c");
  const auto width_c = part->value("width_c");
  if (!height || !centre_c || !width_c || !(*width_c > 0.0)) return std::nullopt;
  CurveBump bump{.height = *height, .centre_c = *centre_c, .width_c = *width_c};
  if (part->covariance.size() == 9) bump.covariance = Eigen::Map<const Eigen::Matrix3d>(part->covariance.data());
  return bump;
}

SplineCurve with_bump(const Curve& curve, const CurveBump& bump) {
  const Value sum = [&](double temp_c) { return evaluate(curve, temp_c) + bump.height * bump.shape(temp_c); };
  const std::vector<double> knots = first_knots(curve, bump);
  double least = sum(knots.front());
  double most = least;
  for (const double knot_c : knots) {
    least = std::min(least, sum(knot_c));
    most = std::max(most, sum(knot_c));
  }
  SplineCurve spline;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    add_pieces(sum, knots[k], knots[k + 1], kPieceTolerance * (most - least), kMostHalvings, spline);
  }
  spline.knots_c.push_back(knots.back());
  return spline;
}

CurveData without_bump(CurveData data, const CurveBump& bump) {
  for (CurveRow& row : data.rows) row.value -= bump.height * bump.shape(row.temp_c);
  return data;
}

void add_bump(const CurveBump& bump, CurveFit& fit) {
  fit.curve = with_bump(fit.curve, bump);
  Contribution part{.name = kBump,
                    .basis = "height, place and width of the accepted bump, as the search that named it knew them"};
  for (const CurvePoint& point : fit.points) part.u.push_back(bump.error_at(point.temp_c));
  part.u_fresh = part.u;
  fit.budget.push_back(std::move(part));
  for (std::size_t i = 0; i < fit.points.size(); ++i) {
    CurvePoint& point = fit.points[i];
    point.value = evaluate(fit.curve, point.temp_c);
    point.ci95 = expanded_uncertainty(fit.budget, Band::mean, i);
    if (point.pi95) point.pi95 = expanded_uncertainty(fit.budget, Band::fresh_power_on, i);
  }
}

}  // namespace soak::calib
