// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// Refuses (bad_input) a rate that is not finite and positive.
[[nodiscard]] base::Status check_rate(double rate_hz);

/// Refuses (bad_input) infinite samples, naming the first of them; `first`: index of samples[0] in its record.
[[nodiscard]] base::Status check_none_infinite(std::span<const double> samples, std::size_t first = 0);

/// Equally spaced samples, NaN where one is missing.
struct SampleGrid {
  double rate_hz = 0.0;
  std::vector<double> t_s;  ///< time of each sample; of a missing one, where it would have been
  std::vector<double> values;
  double scatter = 0.0;  ///< of the times about even steps: root mean square, in steps
};

/// Puts timed samples on a grid of equal steps.
///
/// The step is the one that makes the distances of neighbours whole numbers of steps: it starts from the median
/// distance and is refined over all distances of up to ten of these, so that lost samples, times that were printed
/// coarsely and jitter leave it right. Where most steps would then be missing and twenty distances together are always
/// much the same, samples arrive in bursts, and their mean distance is the step. Each sample lies at the whole number
/// of steps (one at least) that a clock which follows the times slowly makes of its distance; steps between are missing
/// samples.
///
/// Rows without a value (NaN) are passed over first: a slow channel among fast ones comes out at its own rate. At each
/// index in `breaks` (rising) a new stretch begins however close it follows: at least kBreak missing samples go before
/// it. Refuses lengths that differ, times that do not rise (naming the sample), fewer than two samples, a time axis
/// with more than 20 missing samples for each present one, and a rate that changes by more than a tenth between the
/// halves.
inline constexpr std::size_t kBreak = 16;
[[nodiscard]] base::Result<SampleGrid> equally_spaced(std::span<const double> t_s, std::span<const double> values,
                                                      std::span<const std::size_t> breaks = {});

/// Samples [first, last) none of which is missing.
struct SampleRange {
  std::size_t first = 0;
  std::size_t last = 0;

  [[nodiscard]] std::size_t count() const { return last - first; }
};

/// The stretches without a missing sample, in order.
[[nodiscard]] std::vector<SampleRange> stretches_of(std::span<const double> values);

/// Fills gaps of up to `longest` missing samples between present ones by a straight line; returns how many were filled.
std::size_t fill_short_gaps(std::span<double> values, std::size_t longest);

/// Takes the mean of each stretch off it: what stays when a unit stands in one position after the other.
void remove_stretch_means(std::span<double> values);

}  // namespace soak::calib::signal
