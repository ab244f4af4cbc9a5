// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace soak::calib::signal::wavelet {

/// Longest filter that the kernels take.
constexpr std::size_t kMaxLength = 20;

/// Taps of a two-channel filter bank in polyphase form: tap t of the two output channels over the two input channels.
struct PolyphaseTap {
  double first_by_first = 0.0;  ///< first output by first input
  double first_by_second = 0.0;
  double second_by_first = 0.0;
  double second_by_second = 0.0;
};

/// All taps, half as many as the filters are long.
struct Polyphase {
  std::size_t taps = 0;
  std::array<PolyphaseTap, kMaxLength / 2> tap;
};

// The instruction set of each function is chosen at run time; the results are the same bits. Arrays do not overlap.

/// even[i] = z[2 i], odd[i] = z[2 i + 1] for i < pairs.
void deinterleave(std::size_t pairs, const double* z, double* even, double* odd);

/// z[2 i] = even[i], z[2 i + 1] = odd[i] for i < pairs.
void interleave(std::size_t pairs, const double* even, const double* odd, double* z);

/// first_out[i] = sum over t of first_by_first[t] first_in[i + t] + first_by_second[t] second_in[i + t], second_out[i]
/// alike, for i < count; the inputs have count + taps - 1 values. Terms are added in this order.
void filter_bank(std::size_t count, const Polyphase& bank, const double* first_in, const double* second_in,
                 double* first_out, double* second_out);

/// Whether none of the values is infinite or NaN.
[[nodiscard]] bool all_finite(std::size_t count, const double* values);

}  // namespace soak::calib::signal::wavelet
