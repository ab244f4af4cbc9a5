// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "calib/signal/wavelet/detail/kernels.h"

// The functions of calib/signal/wavelet/detail/kernels.h compiled once, for any processor: see
// wavelet_kernels_baseline.cpp.
namespace soak::calib::signal::wavelet::baseline {

void filter_bank(std::size_t count, const Polyphase& bank, const double* first_in, const double* second_in,
                 double* first_out, double* second_out);

}  // namespace soak::calib::signal::wavelet::baseline
