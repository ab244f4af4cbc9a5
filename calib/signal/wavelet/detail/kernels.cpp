// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/kernels.h"

#include <cstring>

#include "base/instruction_set.h"

namespace soak::calib::signal::wavelet {
namespace {

/// Sums kept side by side.
constexpr std::size_t kLanes = 16;

/// Four values side by side.
using Four [[gnu::vector_size(32)]] = double;

/// Sums of both output channels at four neighbouring places.
struct FourSums {
  Four first = {};
  Four second = {};

  SOAK_INLINE void add(double by_first, double by_second, const double* in) {
    Four x;
    std::memcpy(&x, in, sizeof x);
    first += by_first * x;
    second += by_second * x;
  }
  SOAK_INLINE void store(double* first_out, double* second_out) const {
    std::memcpy(first_out, &first, sizeof first);
    std::memcpy(second_out, &second, sizeof second);
  }
};

/// As many neighbouring places as keep loads and sums equally busy in AVX2's registers (measured: with 2 or 4 groups of
/// four, and without two taps per turn of the loop, it takes 1.2 to 1.7 times as long).
constexpr std::size_t kPlaces = 12;

struct Sums {
  FourSums a, b, c;

  SOAK_INLINE void add_tap(const PolyphaseTap& tap, const double* first_in, const double* second_in) {
    a.add(tap.first_by_first, tap.second_by_first, first_in);
    b.add(tap.first_by_first, tap.second_by_first, first_in + 4);
    c.add(tap.first_by_first, tap.second_by_first, first_in + 8);
    a.add(tap.first_by_second, tap.second_by_second, second_in);
    b.add(tap.first_by_second, tap.second_by_second, second_in + 4);
    c.add(tap.first_by_second, tap.second_by_second, second_in + 8);
  }
  SOAK_INLINE void store(double* first_out, double* second_out) const {
    a.store(first_out, second_out);
    b.store(first_out + 4, second_out + 4);
    c.store(first_out + 8, second_out + 8);
  }
};

SOAK_INLINE void filter_places(const Polyphase& bank, const double* first_in, const double* second_in,
                               double* first_out, double* second_out) {
  Sums sums;
#pragma GCC unroll 2
  for (std::size_t t = 0; t < bank.taps; ++t) sums.add_tap(bank.tap[t], first_in + t, second_in + t);
  sums.store(first_out, second_out);
}

SOAK_INLINE void filter_one(const Polyphase& bank, const double* first_in, const double* second_in, double* first_out,
                            double* second_out) {
  double first = 0.0;
  double second = 0.0;
  for (std::size_t t = 0; t < bank.taps; ++t) {
    first += bank.tap[t].first_by_first * first_in[t];
    second += bank.tap[t].second_by_first * first_in[t];
    first += bank.tap[t].first_by_second * second_in[t];
    second += bank.tap[t].second_by_second * second_in[t];
  }
  *first_out = first;
  *second_out = second;
}

}  // namespace

SOAK_CLONES void deinterleave(std::size_t pairs, const double* __restrict z, double* __restrict even,
                              double* __restrict odd) {
  for (std::size_t i = 0; i < pairs; ++i) {
    even[i] = z[2 * i];
    odd[i] = z[2 * i + 1];
  }
}

SOAK_CLONES void interleave(std::size_t pairs, const double* __restrict even, const double* __restrict odd,
                            double* __restrict z) {
  for (std::size_t i = 0; i < pairs; ++i) {
    z[2 * i] = even[i];
    z[2 * i + 1] = odd[i];
  }
}

SOAK_CLONES void filter_bank(std::size_t count, const Polyphase& bank, const double* __restrict first_in,
                             const double* __restrict second_in, double* __restrict first_out,
                             double* __restrict second_out) {
  std::size_t i = 0;
  for (; i + kPlaces <= count; i += kPlaces) {
    filter_places(bank, first_in + i, second_in + i, first_out + i, second_out + i);
  }
  for (; i < count; ++i) filter_one(bank, first_in + i, second_in + i, first_out + i, second_out + i);
}

SOAK_CLONES bool all_finite(std::size_t count, const double* values) {
  // 0 x is NaN for infinite x and NaN, and stays so in the sum.
  double sum[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) sum[k] += 0.0 * values[i + k];
  }
  for (; i < count; ++i) sum[0] += 0.0 * values[i];
  for (std::size_t k = 1; k < kLanes; ++k) sum[0] += sum[k];
  return sum[0] == 0.0;
}

}  // namespace soak::calib::signal::wavelet
