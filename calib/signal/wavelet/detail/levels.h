// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/result.h"
#include "calib/signal/wavelet/detail/kernels.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal::wavelet {

/// Refuses a wavelet whose filters do not all have the same even length from 2 to kMaxLength.
[[nodiscard]] base::Status check_filters(const Wavelet& wavelet);

/// Refuses a value that is negative or not finite; `what` names the values ("threshold"), `where` tells the level.
[[nodiscard]] base::Status check_not_negative(std::span<const double> values, std::string_view what);

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
