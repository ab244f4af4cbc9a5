// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/detail/fourier.h"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace soak::calib::signal {
namespace {

using Complex = std::complex<double>;

bool is_smooth(std::size_t n) {
  for (const std::size_t p : {2U, 3U, 5U}) {
    while (n % p == 0) n /= p;
  }
  return n == 1;
}

Eigen::FFT<double> half_spectrum_transform() {
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  return fft;
}

/// exp(-pi i j^2/n), j = 0..n - 1: the chirp. j^2 is taken modulo 2 n first, so that large angles keep their digits.
std::vector<Complex> chirp_of(std::size_t n) {
  std::vector<Complex> chirp(n);
  for (std::uint64_t j = 0; j < n; ++j) {
    const double turns = static_cast<double>(j * j % (2 * n)) / static_cast<double>(n);
    chirp[j] = std::polar(1.0, -std::numbers::pi * turns);
  }
  return chirp;
}

}  // namespace

struct RealFourier::Impl {
  std::size_t n = 0;
  Eigen::FFT<double> fft = half_spectrum_transform();
  std::vector<Complex> spectrum;
  std::vector<Complex> chirp;   ///< empty: n is smooth
  std::vector<Complex> kernel;  ///< transform of the chirp's conjugate
  std::vector<Complex> padded;
  std::vector<Complex> product;

  void prepare_bluestein() {
    chirp = chirp_of(n);
    const std::size_t length = std::bit_ceil(2 * n - 1);
    padded.assign(length, 0.0);
    for (std::size_t j = 0; j < n; ++j) padded[j] = padded[(length - j) % length] = std::conj(chirp[j]);
    kernel.resize(length);
    product.resize(length);
    fft.fwd(kernel.data(), padded.data(), static_cast<Eigen::Index>(length));
  }

  // With 2 j k = j^2 + k^2 - (k - j)^2:  X_k = c_k sum_j (x_j c_j) conj(c_(k-j)).
  void bluestein(std::span<const double> x) {
    std::fill(padded.begin(), padded.end(), 0.0);
    for (std::size_t j = 0; j < n; ++j) padded[j] = x[j] * chirp[j];
    const auto length = static_cast<Eigen::Index>(padded.size());
    fft.fwd(product.data(), padded.data(), length);
    for (std::size_t k = 0; k < product.size(); ++k) product[k] *= kernel[k];
    fft.inv(padded.data(), product.data(), length);
    for (std::size_t k = 0; k < spectrum.size(); ++k) spectrum[k] = chirp[k] * padded[k];
  }
};

RealFourier::RealFourier(std::size_t n) : impl_(std::make_unique<Impl>()) {
  impl_->n = n;
  impl_->spectrum.resize(n / 2 + 1);
  if (!is_smooth(n)) impl_->prepare_bluestein();
}

RealFourier::RealFourier(RealFourier&&) noexcept = default;
RealFourier& RealFourier::operator=(RealFourier&&) noexcept = default;
RealFourier::~RealFourier() = default;

std::span<const Complex> RealFourier::forward(std::span<const double> x) {
  if (impl_->chirp.empty()) {
    impl_->fft.fwd(impl_->spectrum.data(), x.data(), static_cast<Eigen::Index>(impl_->n));
  } else {
    impl_->bluestein(x);
  }
  return impl_->spectrum;
}

std::vector<double> inverse_fourier(std::span<const Complex> half_spectrum) {
  std::vector<double> x(2 * (half_spectrum.size() - 1));
  half_spectrum_transform().inv(x.data(), half_spectrum.data(), static_cast<Eigen::Index>(x.size()));
  return x;
}

}  // namespace soak::calib::signal
