// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "base/result.h"

namespace soak::anfis {

/// No number of a model or of its training data may be larger: no sum or product of an evaluation overflows.
inline constexpr double kLargestNumber = 1e100;

/// Shape of a membership function [AH05 §5.3 layer 1].
enum class Shape {
  bell,                ///< generalised bell
  gaussian,            ///< Gaussian
  two_sided_gaussian,  ///< two Gaussian flanks with a top of degree 1 between them
  triangle,            ///< piecewise linear, one peak
  trapezoid,           ///< piecewise linear, a top of degree 1
};
inline constexpr std::array<Shape, 5> kShapes = {Shape::bell, Shape::gaussian, Shape::two_sided_gaussian,
                                                 Shape::triangle, Shape::trapezoid};

/// "bell", "gaussian", "two_sided_gaussian", "triangle", "trapezoid".
[[nodiscard]] std::string_view name(Shape shape);

/// Names of the parameters of a shape, in the order of Membership::parameters:
///   bell                width a, slope b, centre c           1 / (1 + |(u - c)/a|^(2b))        [AH05 eq. 5.6]
///   gaussian            width sigma, centre c                exp(-((u - c)/sigma)^2 / 2)       [AH05 eq. 5.7]
///   two_sided_gaussian  left_width, left, right_width, right the Gaussian flank below left and above right, 1 between
///   triangle            left, peak, right                    0 outside (left, right), 1 at the peak
///   trapezoid           left, top_left, top_right, right     0 outside (left, right), 1 on [top_left, top_right]
/// Widths and the slope are positive (at least 1e-50); positions rise (two_sided_gaussian: left <= right; triangle and
/// trapezoid: feet strictly apart from their top).
[[nodiscard]] std::span<const std::string_view> parameter_names(Shape shape);

/// Number of parameters of a shape: 2..4.
[[nodiscard]] constexpr std::size_t parameter_count(Shape shape) {
  return shape == Shape::gaussian ? 2 : shape == Shape::bell || shape == Shape::triangle ? 3 : 4;
}

/// One membership function of one input, in scaled units (see Model).
struct Membership {
  Shape shape = Shape::bell;
  std::array<double, 4> parameters{};  ///< as in parameter_names(); those that the shape does not have are 0

  friend bool operator==(const Membership&, const Membership&) = default;
};

/// The usual two, without having to remember the order of parameters.
[[nodiscard]] Membership bell(double width, double slope, double centre);
[[nodiscard]] Membership gaussian(double width, double centre);

/// Whether every parameter is finite, at most 1e100 and in the range of parameter_names(); the message names the
/// parameter.
[[nodiscard]] base::Status validate(const Membership& membership);

/// Degree of membership at u: 0..1. Finite for every finite u of a valid membership.
[[nodiscard]] double degree(const Membership& membership, double u);

/// Natural logarithm of the degree, exact where the degree itself underflows. Where a triangle or trapezoid is zero it
/// is a large negative number that falls with the distance from the support (-1e6 (1 + distance / support length)):
/// it decides which rule is nearest where none fires.
[[nodiscard]] double log_degree(const Membership& membership, double u);

/// Derivatives of the degree by each parameter at u, 0 for parameters that the shape does not have. On the kinks of
/// triangle and trapezoid: the mean of both sides.
[[nodiscard]] std::array<double, 4> degree_derivatives(const Membership& membership, double u);

/// Derivatives of its logarithm by each parameter: those of the degree divided by it, exact where it underflows; 0
/// where a triangle or trapezoid does not fire.
[[nodiscard]] std::array<double, 4> log_degree_derivatives(const Membership& membership, double u);

/// Where the membership is 1: the centre, the peak, the middle of the top.
[[nodiscard]] double centre(const Membership& membership);

}  // namespace soak::anfis
