// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// What is taken off each section before its transform.
enum class Detrend { none, mean, line };

/// How to average periodograms (Welch 1967).
struct WelchOptions {
  std::size_t section = 4096;  ///< samples per section; reduced to the length of a shorter signal
  double overlap = 0.5;        ///< share of a section that the next one repeats, [0, 0.95]
  Detrend detrend = Detrend::mean;
};

/// One-sided power spectral density in U^2/Hz: summed over the frequencies times their spacing it gives the variance.
struct Spectrum {
  std::vector<double> frequency_hz;  ///< 0 to rate/2
  std::vector<double> density;
  std::size_t sections = 0;
  double degrees_of_freedom = 0.0;  ///< effective, of each value (overlapping sections are dependent)
};

/// Welch's estimate with a Hann window. A NaN sample is missing: sections that hold one are left out.
/// Refuses a rate that is not finite and positive, infinite samples, fewer than 8 samples, an overlap outside its
/// range, and a signal without one whole section.
[[nodiscard]] base::Result<Spectrum> welch(std::span<const double> samples, double rate_hz,
                                           const WelchOptions& options);

}  // namespace soak::calib::signal
