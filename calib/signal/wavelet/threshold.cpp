// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/threshold.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "base/instruction_set.h"
#include "calib/signal/wavelet/detail/median_size.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kLanes = 8;

// Rules without a branch: noise would make every one of them a coin toss. T >= 0.

struct Soft {
  /// d - clamp(d, -T, T)
  SOAK_INLINE static double kept(double d, double threshold) {
    const double below = d < threshold ? d : threshold;
    return d - (below > -threshold ? below : -threshold);
  }
};

struct Hard {
  SOAK_INLINE static double kept(double d, double threshold) { return std::abs(d) > threshold ? d : 0.0; }
};

struct Garrote {
  /// d - T^2/d as d (1 - q^2) with q = T/max(|d|, T)
  SOAK_INLINE static double kept(double d, double threshold) {
    const double size = std::abs(d) > threshold ? std::abs(d) : threshold;
    const double q = threshold / (size > kLeast ? size : kLeast);
    return d - d * q * q;
  }
  static constexpr double kLeast = std::numeric_limits<double>::min();  // 0/0 has no value
};

template <class Rule>
SOAK_INLINE void shrink_all(std::size_t count, double* d, double threshold) {
  const std::size_t whole = count - count % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) d[i + k] = Rule::kept(d[i + k], threshold);
  }
  for (std::size_t i = whole; i < count; ++i) d[i] = Rule::kept(d[i], threshold);
}

SOAK_CLONES void shrink_soft(std::size_t count, double* d, double threshold) { shrink_all<Soft>(count, d, threshold); }

SOAK_CLONES void shrink_hard(std::size_t count, double* d, double threshold) { shrink_all<Hard>(count, d, threshold); }

SOAK_CLONES void shrink_garrote(std::size_t count, double* d, double threshold) {
  shrink_all<Garrote>(count, d, threshold);
}

}  // namespace

void shrink(std::span<double> coefficients, double threshold, Shrinkage shrinkage) {
  switch (shrinkage) {
    case Shrinkage::none:
      return;
    case Shrinkage::soft:
      return shrink_soft(coefficients.size(), coefficients.data(), threshold);
    case Shrinkage::hard:
      return shrink_hard(coefficients.size(), coefficients.data(), threshold);
    case Shrinkage::garrote:
      return shrink_garrote(coefficients.size(), coefficients.data(), threshold);
  }
}

double noise_level(std::span<const double> details) {
  constexpr double kMedianOfNormal = 0.6745;  // median of |x| for a standard normal x, as printed
  return denoising::median_size(details) / kMedianOfNormal;
}

double universal_threshold(double sigma, double n) { return n > 1.0 ? sigma * std::sqrt(2.0 * std::log(n)) : 0.0; }

}  // namespace soak::calib::signal
