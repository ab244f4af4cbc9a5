// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/detail/membership_functions.h"

#include <algorithm>

namespace soak::anfis::inference {
namespace {

double bell_log(const Membership& m, double u) {
  const auto& [width, slope, centre, unused] = m.parameters;
  return bell_log_degree(bell_distance(u, width, centre), slope);
}

double two_sided_log(const Membership& m, double u) {
  const auto& [left_width, left, right_width, right] = m.parameters;
  if (u < left) return -0.5 * gaussian_distance(u, left_width, left);
  return u > right ? -0.5 * gaussian_distance(u, right_width, right) : 0.0;
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
  if (degree > 0.0) return logarithm(degree);
  const double outside = std::max(p.left - u, u - p.right);
  return kNeverFires * (1.0 + outside / (p.right - p.left));
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
    const auto [width, centre] = gaussian_log_derivatives(u, gaussian_distance(u, left_width, left), left_width, left);
    d[0] = width;
    d[1] = centre;
  } else if (u > right) {
    const auto [width, centre] =
        gaussian_log_derivatives(u, gaussian_distance(u, right_width, right), right_width, right);
    d[2] = width;
    d[3] = centre;
  }
  return d;
}

}  // namespace

double degree_of(const Membership& membership, double u) {
  u = std::clamp(u, -kFarthest, kFarthest);
  const auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell:
      return bell_degree(bell_distance(u, p[0], p[2]), p[1]);
    case Shape::gaussian:
      return gaussian_degree(gaussian_distance(u, p[0], p[1]));
    case Shape::two_sided_gaussian:
      return exponential(two_sided_log(membership, u));
    case Shape::triangle:
    case Shape::trapezoid:
      return polygon_degree(polygon(membership), u);
  }
  return 0.0;
}

double log_degree_of(const Membership& membership, double u) {
  u = std::clamp(u, -kFarthest, kFarthest);
  switch (membership.shape) {
    case Shape::bell:
      return bell_log(membership, u);
    case Shape::gaussian:
      return -0.5 * gaussian_distance(u, membership.parameters[0], membership.parameters[1]);
    case Shape::two_sided_gaussian:
      return two_sided_log(membership, u);
    case Shape::triangle:
    case Shape::trapezoid:
      return polygon_log(polygon(membership), u);
  }
  return 0.0;
}

std::array<double, 4> log_derivatives_of(const Membership& membership, double u) {
  u = std::clamp(u, -kFarthest, kFarthest);
  const auto& p = membership.parameters;
  switch (membership.shape) {
    case Shape::bell: {
      const double distance = bell_distance(u, p[0], p[2]);
      const auto d = bell_log_derivatives(u, distance, bell_degree(distance, p[1]), p[0], p[1], p[2]);
      return {d[0], d[1], d[2], 0.0};
    }
    case Shape::gaussian: {
      const auto d = gaussian_log_derivatives(u, gaussian_distance(u, p[0], p[1]), p[0], p[1]);
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

}  // namespace soak::anfis::inference
