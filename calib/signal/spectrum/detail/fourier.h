// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace soak::calib::signal {

/// Discrete Fourier transform of real sequences of one length n (8..2^30), X_k = sum_j x_j exp(-2 pi i j k/n), k =
/// 0..n/2; the other half is the mirrored conjugate. O(n log n) for every n: Eigen's mixed-radix transform where n has
/// no prime factor above 5, else Bluestein's convolution with a chirp [Bluestein 1970]. Not for two threads at once.
class RealFourier {
 public:
  explicit RealFourier(std::size_t n);
  RealFourier(RealFourier&&) noexcept;
  RealFourier& operator=(RealFourier&&) noexcept;
  ~RealFourier();

  /// n/2 + 1 values; valid until the next call.
  [[nodiscard]] std::span<const std::complex<double>> forward(std::span<const double> x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// x_j = (1/n) sum_k X_k exp(2 pi i j k/n) for a half spectrum of n/2 + 1 values, n a power of two from 4 on.
[[nodiscard]] std::vector<double> inverse_fourier(std::span<const std::complex<double>> half_spectrum);

}  // namespace soak::calib::signal
