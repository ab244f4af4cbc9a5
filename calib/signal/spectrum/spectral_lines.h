// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/signal/spectrum/spectrum.h"

namespace soak::calib::signal {

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
