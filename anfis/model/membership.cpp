// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/membership.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "anfis/model/detail/membership_functions.h"

namespace soak::anfis {
namespace {

constexpr std::array<std::string_view, 3> kBell = {"width", "slope", "centre"};
constexpr std::array<std::string_view, 2> kGaussian = {"width", "centre"};
constexpr std::array<std::string_view, 4> kTwoSided = {"left_width", "left", "right_width", "right"};
constexpr std::array<std::string_view, 3> kTriangle = {"left", "peak", "right"};
constexpr std::array<std::string_view, 4> kTrapezoid = {"left", "top_left", "top_right", "right"};

/// Shorter lengths have squares that underflow, farther positions such that overflow.
constexpr double kShortest = 1e-50;
constexpr double kLargest = 1e100;

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
  return base::bad_input("the shape is none of those known", "shape");
}

}  // namespace

std::string_view name(Shape shape) {
  switch (shape) {
    case Shape::bell:
      return "bell";
    case Shape::gaussian:
      return "gaussian";
    case Shape::two_sided_gaussian:
      return "two_sided_gaussian";
    case Shape::triangle:
      return "triangle";
    case Shape::trapezoid:
      return "trapezoid";
  }
  return "unknown";
}

std::span<const std::string_view> parameter_names(Shape shape) {
  switch (shape) {
    case Shape::bell:
      return kBell;
    case Shape::gaussian:
      return kGaussian;
    case Shape::two_sided_gaussian:
      return kTwoSided;
    case Shape::triangle:
      return kTriangle;
    case Shape::trapezoid:
      return kTrapezoid;
  }
  return {};
}

Membership bell(double width, double slope, double centre) { return {Shape::bell, {width, slope, centre, 0.0}}; }

Membership gaussian(double width, double centre) { return {Shape::gaussian, {width, centre, 0.0, 0.0}}; }

base::Status validate(const Membership& membership) {
  const auto names = parameter_names(membership.shape);
  for (std::size_t i = 0; i < membership.parameters.size(); ++i) {
    const double value = membership.parameters[i];
    if (i >= names.size() ? value != 0.0 : !(std::abs(value) <= kLargest)) {
      const std::string parameter(i < names.size() ? names[i] : "unused parameter");
      return base::bad_input(
          "the " + parameter + (i < names.size() ? " is not a finite number of at most 1e100" : " must be 0"),
          parameter);
    }
  }
  return in_order(membership);
}

double degree(const Membership& membership, double u) { return inference::degree_of(membership, u); }

double log_degree(const Membership& membership, double u) { return inference::log_degree_of(membership, u); }

std::array<double, 4> degree_derivatives(const Membership& membership, double u) {
  std::array<double, 4> derivatives = inference::log_derivatives_of(membership, u);
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
