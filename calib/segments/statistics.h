// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/vocabulary/segment.h"

namespace soak::calib {

/// Straight line y = mean_y + slope·(x − mean_x) by least squares; slope 0 where x does not vary.
struct Line {
  double mean_x = 0.0;
  double mean_y = 0.0;
  double slope = 0.0;
};
[[nodiscard]] Line fit_line(std::span<const double> x, std::span<const double> y);

/// Step q that a sensor's readings are rounded to, as the samples of a whole recording show it: the smallest distance
/// between numbers that occur, if all but 1 % of the distances between neighbouring ones are multiples of it; 0 where
/// they are not, or only one number occurs. NaN samples are passed over. Looks at 100,000 samples at most, evenly
/// spread.
[[nodiscard]] double output_step(std::span<const double> samples);
/// So many samples are looked at, at most.
inline constexpr std::size_t kStepSamples = 100000;
/// The same from the samples that are looked at, those of thinned() or Thinner.
[[nodiscard]] double output_step_of(std::vector<double> shown);

/// Root mean square error that rounding to steps q leaves in the mean of samples of variance s^2, however many, for a
/// true mean anywhere between two steps: the larger of
///   q^2/(2 pi^2) sum_k exp(-4 pi^2 k^2 sigma^2/q^2)/k^2,  sigma^2 = max(0, s^2 - q^2/12),   of Gaussian noise, and
///   (q^2/4 - s^2)/3,   of less noise than that, which goes between two codes only.
/// q/sqrt(12) where the sensor shows one number; next to nothing from a noise of half a step on. Noise of 0.3-0.4 steps
/// averages the rounding away better than this says: two codes do not tell it from less.
[[nodiscard]] double rounding_error(double step, double variance);

/// Samples that stand alone: farther than kSpikeSigmas standard deviations from the median of their four nearest
/// neighbours (the first and last of all: ten times as far), while those lie within a quarter of that. A flipped bit on
/// the wire that passes the checksum looks so; a body does not move for one sample. The standard deviation is 1.48
/// times the median distance from the median, or the same of the differences between neighbours over sqrt(2), or the
/// output step, whichever is largest. No sample where more than 1 % do, nor where that deviation is 0, nor among fewer
/// than 12. NaN samples are passed over, infinite ones stand alone. Rising indices; cost linear in the length.
[[nodiscard]] std::vector<std::size_t> find_spikes(std::span<const double> samples, double step);
inline constexpr double kSpikeSigmas = 20.0;

/// Statistics of a stretch of equally spaced samples; NaN samples are passed over, and so are spikes (find_spikes()).
///
/// `variance` is that of the samples about their mean. `standard_error` is that of the mean: as
/// signal::standard_error_of_mean() states it (under the correlation that the samples show, and not below the Allan
/// deviation at the length of the stretch as far as the stretch itself can tell), and the rounding_error() of `step` in
/// quadrature. No number is taken to be known better than in float32 (24 bits), which samples are sent and stored in:
/// that stands in for a smaller or unknown (0) step. Cost linear in the length.
[[nodiscard]] SensorStatistics describe(std::span<const double> samples, double step = 0.0);

}  // namespace soak::calib
