// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace soak::base {

/// Middle value (mean of the two middle ones for an even count). NaN for no values. O(n).
[[nodiscard]] double median(std::span<const double> values);

/// Value t with P(|X| < t) = `probability` for Student's distribution with `degrees_of_freedom` > 0 (need not be
/// whole).
[[nodiscard]] double student_t_two_sided(double probability, double degrees_of_freedom);

/// Upper tail P(X > x) of the chi-squared distribution with `degrees_of_freedom` > 0 (need not be whole).
[[nodiscard]] double chi_squared_upper_tail(double x, double degrees_of_freedom);

/// Upper tail P(X > x) of the F distribution with `numerator` and `denominator` degrees of freedom, both > 0 (need not
/// be whole). Keeps its relative accuracy far out in the tail.
[[nodiscard]] double f_upper_tail(double x, double numerator, double denominator);

/// Value x with P(X < x) = `probability`, in (0, 1), for the chi-squared distribution.
[[nodiscard]] double chi_squared_quantile(double probability, double degrees_of_freedom);

}  // namespace soak::base
