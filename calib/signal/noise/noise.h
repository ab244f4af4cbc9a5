// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace soak::calib::signal {

/// Simulated noise of a rate sensor read at `rate_hz` (> 0), to test with: `count` samples, each the mean of the rate
/// over one sample interval. The seed determines them; the kinds of noise draw from streams of their own, so that one
/// seed gives independent records of different kinds. In the units of the rate U; the coefficients are those of
/// IEEE 952.
struct NoiseSource {
  double rate_hz = 1.0;
  std::uint64_t seed = 0;
};

/// White noise, angle random walk N in U*sqrt(s) (that is U/sqrt(Hz)): sigma per sample N*sqrt(rate), Allan deviation
/// N/sqrt(tau). PSD, one-sided: 2 N^2.
[[nodiscard]] std::vector<double> white_noise(std::size_t count, double angle_random_walk, const NoiseSource& source);

/// Flicker noise whose Allan deviation is bias_instability*sqrt(2 ln2/pi) = 0.664 B at every averaging time, exactly:
/// the means over the sample intervals of a continuous flicker noise with the one-sided PSD B^2/(pi f) [AH05 eq. 2.16;
/// IEEE 952]. The first sample is 0; flicker noise has no mean of its own, only differences of means have a spread.
/// Circulant embedding of the second differences of its phase [Davies, Harte 1987]: O(n log n), working memory 12 n
/// values.
[[nodiscard]] std::vector<double> flicker_noise(std::size_t count, double bias_instability, const NoiseSource& source);

/// Rate random walk K in U/sqrt(s): the means over the sample intervals of a continuous random walk that starts at 0,
/// hence an Allan deviation of K*sqrt(tau/3) at every averaging time. PSD, one-sided: 2 K^2/(2 pi f)^2 [AH05 eq. 2.14].
[[nodiscard]] std::vector<double> random_walk(std::size_t count, double rate_random_walk, const NoiseSource& source);

/// Ramp R in U/s from 0: Allan deviation R*tau/sqrt(2). Nothing random.
[[nodiscard]] std::vector<double> rate_ramp(std::size_t count, double ramp, double rate_hz);

/// Stationary first-order Gauss-Markov process with standard deviation sigma and correlation time in s (sampled, not
/// averaged): autocorrelation sigma^2 exp(-|t|/T) [AH05 eq. 2.23].
[[nodiscard]] std::vector<double> gauss_markov_noise(std::size_t count, double sigma, double correlation_s,
                                                     const NoiseSource& source);

/// Angle quantisation Q in U*s: differences, over the interval, of an integral that is off by independent, uniformly
/// distributed rounding errors of standard deviation Q (one step is sqrt(12) Q). Allan deviation sqrt(3) Q/tau.
[[nodiscard]] std::vector<double> quantization_noise(std::size_t count, double quantization, const NoiseSource& source);

}  // namespace soak::calib::signal
