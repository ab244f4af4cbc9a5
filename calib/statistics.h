// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "calib/segment.h"

namespace soak::calib {

/// Middle value (mean of the two middle ones for an even count). NaN for no values.
[[nodiscard]] double median(std::span<const double> values);

/// Straight line y = mean_y + slope·(x − mean_x) by least squares; slope 0 where x does not vary.
struct Line {
  double mean_x = 0.0;
  double mean_y = 0.0;
  double slope = 0.0;
};
[[nodiscard]] Line fit_line(std::span<const double> x, std::span<const double> y);

/// Statistics of a stretch of equally spaced samples; NaN samples are passed over.
///
/// `variance` is that of the samples about their mean. `standard_error` is that of the mean under the correlation that
/// the samples show: s²/n · (1 + 2 Σ_k (1 − k/n) ρ_k), the sum cut where the sum of two neighbouring autocorrelations
/// turns negative (initial positive sequence, Geyer 1992), on samples from which a straight line was removed, and never
/// below the value for white noise. Long stretches are first averaged to at most 512 groups: cost linear in the length.
[[nodiscard]] SensorStatistics describe(std::span<const double> samples);

/// Value t with P(|X| < t) = `probability` for Student's distribution with `degrees_of_freedom` > 0 (need not be
/// whole).
[[nodiscard]] double student_t_two_sided(double probability, double degrees_of_freedom);

/// Upper tail P(X > x) of the chi-squared distribution.
[[nodiscard]] double chi_squared_upper_tail(double x, double degrees_of_freedom);

}  // namespace soak::calib
