// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "calib/signal/wavelet/detail/kernels.h"
#include "calib/signal/wavelet/wavelet.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal::wavelet {

/// A wavelet's filters as the kernels take them.
struct Banks {
  std::size_t length = 0;  ///< F of each filter, even, 2..kMaxLength
  Polyphase analysis;
  Polyphase synthesis;
};

/// Precondition: four filters of one length as in Banks.
[[nodiscard]] Banks banks_of(const Wavelet& wavelet);

/// Number of coefficients, of approximation and detail each, of one level that starts from `samples` values.
[[nodiscard]] std::size_t coefficient_count(std::size_t samples, std::size_t length, Boundary boundary);

/// One level down: coefficient_count() values into `approximation` and `detail` each, which overlap nothing.
void analyse(std::span<const double> signal, const Banks& banks, Boundary boundary, double* approximation,
             double* detail);

/// One level up: all of `signal`, whose length is that which analyse() was given, from as many coefficients as it gave.
void synthesise(std::span<const double> approximation, std::span<const double> detail, const Banks& banks,
                Boundary boundary, std::span<double> signal);

}  // namespace soak::calib::signal::wavelet
