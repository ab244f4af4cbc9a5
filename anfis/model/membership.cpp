// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/membership.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "anfis/model/detail/inference.h"

namespace soak::anfis {
namespace {

constexpr std::array<std::string_view, 3> kBell = {"width", "slope", "centre"};
constexpr std::array<std::string_view, 2> kGaussian = {"width", "centre"};
constexpr std::array<std::string_view, 4> kTwoSided = {"left_width", "left", "right_width", "right"};
constexpr std::array<std::string_view, 3> kTriangle = {"left", "peak", "right"};
constexpr std::array<std::string_view, 4> kTrapezoid = {"left", "top_left", "top_right", "right"};

/// Name of a shape and its parameters, in the order of the enumeration.
struct ShapeTraits {
  std::string_view name;
  std::span<const std::string_view> parameters;
};
constexpr std::array<ShapeTraits, 5> kTraits = {{{"bell", kBell},
                                                 {"gaussian", kGaussian},
                                                 {"two_sided_gaussian", kTwoSided},
                                                 {"triangle", kTriangle},
                                                 {"trapezoid", kTrapezoid}}};

ShapeTraits traits(Shape shape) {
  const auto index = static_cast<std::size_t>(shape);
  return index < kTraits.size() ? kTraits[index] : ShapeTraits{"unknown", {}};
}

/// Shorter lengths have squares that underflow.
constexpr double kShortest = 1e-50;

base::Status positive(const Membership& membership, std::size_t index) {
  if (membership.parameters[index] >= kShortest) return {};
  const std::string parameter(parameter_names(membership.shape)[index]);
  return base::bad_input("the " + parameter + " must be at least 1e-50", parameter);
}

/// parameters[low] < parameters[high], or <= where `may_meet`.
base::Status rising(const Membership& membership, std::size_t low, std::size_t high, bool may_meet = false) {
  const double a = membership.parameters[low];
  const double b = membership.parameters[high];
  if (b - a >= kShortest || (may_meet && a == b)) return {};
  const auto names = parameter_names(membership.shape);
  return base::bad_input(std::string(names[low]) + " must lie below " + std::string(names[high]),
                         std::string(names[low]));
}

base::Status both(base::Status first, base::Status second) { return first ? std::move(second) : std::move(first); }

base::Status in_order(const Membership& m) {
  switch (m.shape) {
    case Shape::bell:
      return both(positive(m, 0), positive(m, 1));
    case Shape::gaussian:
      return positive(m, 0);
    case Shape::two_sided_gaussian:
      return both(both(positive(m, 0), positive(m, 2)), rising(m, 1, 3, true));
    case Shape::triangle:
      return both(rising(m, 0, 1), rising(m, 1, 2));
    case Shape::trapezoid:
      return both(both(rising(m, 0, 1), rising(m, 1, 2, true)), rising(m, 2, 3));
  }
  return base::bad_input("unknown shape of membership", "shape");
}

double bell_log(const Membership& m, double u) {
  const auto& [width, slope, centre, unused] = m.parameters;
  return inference::bell_log_degree(inference::bell_distance(u, width, centre), slope);
}

double two_sided_log(const Membership& m, double u) {
  const auto& [left_width, left, right_width, right] = m.parameters;
  if (u < left) return -0.5 * inference::gaussian_distance(u, left_width, left);
  return u > right ? -0.5 * inference::gaussian_distance(u, right_width, right) : 0.0;
}

/// Feet and top of a piecewise linear membership; a triangle is a trapezoid whose top is a point.
struct Polygon {
  double left, top_left, top_right, right;
};

Polygon polygon(const Membership& m) {
  const auto& p = m.parameters;
  return m.shape == Shape::triangle ? Polygon{p[0], p[1], p[1], p[2]} : Polygon{p[0], p[1], p[2], p[3]};
}

double polygon_degree(const Polygon& p, double u) {
  const double rising = (u - p.left) / (p.top_left - p.left);
  const double falling = (p.right - u) / (p.right - p.top_right);
  return std::max(std::min({rising, falling, 1.0}), 0.0);
}

double polygon_log(const Polygon& p, double u) {
  const double degree = polygon_degree(p, u);
  if (degree > 0.0) return inference::logarithm(degree);
  const double outside = std::max(p.left - u, u - p.right);
  return inference::kNeverFires * (1.0 + outside / (p.right - p.left));
}

/// d ln mu / d (left, top_left, top_right, right): on the rising side ln mu = ln(u - left) - ln(top_left - left).
std::array<double, 4> polygon_log_derivatives(const Polygon& p, double u) {
  std::array<double, 4> d{};
  if (u <= p.left || u >= p.right) return d;
  // The mean of both sides on the kink at the top.
  const double rising = u < p.top_left ? 1.0 : u == p.top_left ? 0.5 : 0.0;
  const double falling = u > p.top_right ? 1.0 : u == p.top_right ? 0.5 : 0.0;
  const double rise = p.top_left - p.left;
  const double fall = p.right - p.top_right;
  d[0] = rising * (1.0 / rise - 1.0 / (u - p.left));
  d[1] = -rising / rise;
  d[2] = falling / fall;
  d[3] = falling * (1.0 / (p.right - u) - 1.0 / fall);
  return d;
}

std::array<double, 4> two_sided_log_derivatives(const Membership& m, double u) {
  const auto& [left_width, left, right_width, right] = m.parameters;
  std::array<double, 4> d{};
  if (u < left) {
    const auto [width, centre] =
        inference::gaussian_log_derivatives(u, inference::gaussian_distance(u, left_width, left), left_width, left);
    d[0] = width;
    d[1] = centre;
  } else if (u > right) {
    const auto [width, centre] =
        inference::gaussian_log_derivatives(u, inference::gaussian_distance(u, right_width, right), right_width, right);
    d[2] = width;
    d[3] = centre;
  }
  return d;
}

}  // namespace

std::string_view name(Shape shape) { return traits(shape).name; }

std::span<const std::string_view> parameter_names(Shape shape) { return traits(shape).parameters; }

Membership bell(double width, double slope, double centre) { return {Shape::bell, {width, slope, centre, 0.0}}; }

Membership gaussian(double width, double centre) { return {Shape::gaussian, {width, centre, 0.0, 0.0}}; }

base::Status validate(const Membership& membership) {
  const auto names = parameter_names(membership.shape);
  for (std::size_t i = 0; i < membership.parameters.size(); ++i) {
    const double value = membership.parameters[i];
    if (i >= names.size() ? value != 0.0 : !(std::abs(value) <= kLargestNumber)) {
      const std::string parameter(i < names.size() ? names[i] : "unused parameter");
      return base::bad_input(
          "the " + parameter + (i < names.size() ? " is not a finite number of at most 1e100" : " must be 0"),
          parameter);
    }
  }
  return in_order(membership);
}

double degree(const Membership& membership, double u) {
  u = std::clamp(u, -inference::kFarthest, inference::kFarthest);
  const auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell:
      return inference::bell_degree(inference::bell_distance(u, p[0], p[2]), p[1]);
    case Shape::gaussian:
      return inference::gaussian_degree(inference::gaussian_distance(u, p[0], p[1]));
    case Shape::two_sided_gaussian:
      return inference::exponential(two_sided_log(membership, u));
    case Shape::triangle:
    case Shape::trapezoid:
      return polygon_degree(polygon(membership), u);
  }
  return 0.0;
}

double log_degree(const Membership& membership, double u) {
  u = std::clamp(u, -inference::kFarthest, inference::kFarthest);
  switch (membership.shape) {
    case Shape::bell:
      return bell_log(membership, u);
    case Shape::gaussian:
      return -0.5 * inference::gaussian_distance(u, membership.parameters[0], membership.parameters[1]);
    case Shape::two_sided_gaussian:
      return two_sided_log(membership, u);
    case Shape::triangle:
    case Shape::trapezoid:
      return polygon_log(polygon(membership), u);
  }
  return 0.0;
}

std::array<double, 4> log_degree_derivatives(const Membership& membership, double u) {
  u = std::clamp(u, -inference::kFarthest, inference::kFarthest);
  const auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell: {
      const double distance = inference::bell_distance(u, p[0], p[2]);
      const auto d =
          inference::bell_log_derivatives(u, distance, inference::bell_degree(distance, p[1]), p[0], p[1], p[2]);
      return {d[0], d[1], d[2], 0.0};
    }
    case Shape::gaussian: {
      const auto d = inference::gaussian_log_derivatives(u, inference::gaussian_distance(u, p[0], p[1]), p[0], p[1]);
      return {d[0], d[1], 0.0, 0.0};
    }
    case Shape::two_sided_gaussian:
      return two_sided_log_derivatives(membership, u);
    case Shape::trapezoid:
      return polygon_log_derivatives(polygon(membership), u);
    case Shape::triangle: {
      const auto d = polygon_log_derivatives(polygon(membership), u);
      return {d[0], d[1] + d[2], d[3], 0.0};
    }
  }
  return {};
}

std::array<double, 4> degree_derivatives(const Membership& membership, double u) {
  std::array<double, 4> derivatives = log_degree_derivatives(membership, u);
  const double mu = degree(membership, u);
  for (double& d : derivatives) d *= mu;
  return derivatives;
}

double centre(const Membership& membership) {
  const auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell:
      return p[2];
    case Shape::gaussian:
    case Shape::triangle:
      return p[1];
    case Shape::two_sided_gaussian:
      return 0.5 * p[1] + 0.5 * p[3];
    case Shape::trapezoid:
      return 0.5 * p[1] + 0.5 * p[2];
  }
  return 0.0;
}

}  // namespace soak::anfis
