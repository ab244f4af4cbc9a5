// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/threshold.h"
#include "calib/signal/wavelet_transform.h"

namespace soak::calib::signal {

/// From which details the level of the noise is taken. finest: one sigma for all levels, right for white noise [AH05
/// eq. 4.14]; one threshold from the length of the signal. per_level: each level its own sigma and its own length, for
/// coloured noise [AH05 eq. 4.15].
enum class NoiseFrom { finest, per_level };

/// How to denoise.
struct DenoisingOptions {
  std::size_t levels = 6;
  Boundary boundary = Boundary::symmetric;
  Shrinkage shrinkage = Shrinkage::soft;
  NoiseFrom noise = NoiseFrom::finest;
  /// Relaxation factor lambda_j of each level's threshold, finest first [AH05 eq. 4.15]; levels beyond the end have 1.
  std::vector<double> relaxation;
  /// One threshold for all levels (still times the relaxation factor) instead of the universal one.
  std::optional<double> threshold;
};

/// A signal split by wavelet multi-resolution analysis.
struct Denoised {
  std::vector<double> signal;  ///< from the approximation and the shrunk details
  std::vector<double> trend;   ///< from the approximation alone: what is slower than 2^levels samples [AH05 fig. 6.1]
  std::vector<double> thresholds;  ///< that of each level, finest first
  std::vector<double> sigma;       ///< noise level found in the details of each level, finest first
};

/// Splits the signal into trend, signal and noise. Refuses what decompose() refuses, a threshold or factor that is
/// negative or not finite, and more factors than levels.
[[nodiscard]] base::Result<Denoised> denoise(std::span<const double> samples, const Wavelet& wavelet,
                                             const DenoisingOptions& options);

}  // namespace soak::calib::signal
