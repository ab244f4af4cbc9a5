// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// What is taken off each section before its transform.
enum class Detrend { none, mean, line };

/// How to average periodograms [Welch 1967].
struct WelchOptions {
  std::size_t section = 4096;  ///< samples per section, any number from 8 on; reduced to the length of a shorter signal
  double overlap = 0.5;        ///< share of a section that the next one repeats, [0, 0.95]
  Detrend detrend = Detrend::mean;
};

/// One-sided power spectral density in U^2/Hz: summed over the frequencies times their spacing it gives the variance.
struct Spectrum {
  std::vector<double> frequency_hz;  ///< 0 to rate/2, section/2 + 1 values
  std::vector<double> density;
  std::size_t sections = 0;
  /// Effective, of each density but those at 0 and rate/2, which have half: density * dof/expectation is distributed
  /// about as chi-squared. With K sections D samples apart [Welch 1967; Percival, Walden 1993 eq. 292b]
  ///   2 K/(1 + 2 sum_(j=1..K-1) (1 - j/K) rho_j),  rho_j = (sum_i w_i w_(i+jD))^2/(sum_i w_i^2)^2
  /// (a Hann window overlapping by half: rho_1 = 1/36). Pairs of sections count as there are, gaps considered.
  double degrees_of_freedom = 0.0;
};

/// Welch's estimate with a periodic Hann window. A NaN sample is missing: sections that hold one are left out.
/// Refuses (bad_input) a rate that is not finite and positive, infinite samples, fewer than 8 samples, sections shorter
/// than 8, an overlap outside its range, and a signal without one whole section. O(n log n).
[[nodiscard]] base::Result<Spectrum> welch(std::span<const double> samples, double rate_hz,
                                           const WelchOptions& options);

/// A line in a spectrum: a vibration, a fan, the mains.
struct SpectralLine {
  double frequency_hz = 0.0;  ///< centre of gravity of the line
  double amplitude = 0.0;     ///< of the sine that it would be, in the unit of the samples
};

/// Lines that stand out of a Welch spectrum (Hann window), strongest first, at most eight: bins whose density exceeds
/// the medians of both sides of their neighbourhood (16 bins each, the nearest three left out) by a factor that noise
/// with the spectrum's degrees of freedom exceeds in about one spectrum of a thousand. The amplitude follows from what
/// stands above the larger median within three bins on either side: a sine of amplitude A has A^2/2 there. Lines within
/// the first six bins are taken for drift. Empty for fewer than 64 bins. O(bins).
[[nodiscard]] std::vector<SpectralLine> spectral_lines(const Spectrum& spectrum);

}  // namespace soak::calib::signal
