// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

namespace soak::calib::signal::wavelet {
namespace {

using Index = std::ptrdiff_t;

/// Places that are worked on at a time: so few that all buffers stay in the nearest cache, and a multiple of the 12
/// that the kernel takes at once.
constexpr Index kBlock = 120;
constexpr Index kMargin = kMaxLength / 2;

using Channel = std::array<double, kBlock + kMargin>;
using Window = std::array<double, 2 * (kBlock + kMargin)>;

Index index_of(std::size_t n) { return static_cast<Index>(n); }

Index modulo(Index i, Index n) { return ((i % n) + n) % n; }

/// Where in a signal of n values the value at any place i of its continuation stands.
Index place_in_signal(Index i, Index n, Boundary boundary) {
  if (boundary == Boundary::periodization) return std::min(modulo(i, n + n % 2), n - 1);
  const Index j = modulo(i, 2 * n);
  return std::min(j, 2 * n - 1 - j);
}

/// `count` values from place `first` on: those of the signal itself where it covers them, else a copy continued beyond
/// the ends, where place(i) tells which value stands at place i.
template <class Place>
const double* window_of(std::span<const double> signal, Index first, Index count, Window& copy, Place&& place) {
  const Index n = index_of(signal.size());
  if (first >= 0 && first + count <= n) return signal.data() + first;
  const auto continued = [&](Index k) { return signal[static_cast<std::size_t>(place(first + k))]; };
  const Index begin = std::clamp<Index>(-first, 0, count);
  const Index end = std::clamp<Index>(n - first, begin, count);
  double* out = copy.data();
  for (Index k = 0; k < begin; ++k) out[k] = continued(k);
  if (begin < end) std::copy(signal.data() + first + begin, signal.data() + first + end, out + begin);
  for (Index k = end; k < count; ++k) out[k] = continued(k);
  return out;
}

const double* signal_window(std::span<const double> signal, Index first, Index count, Boundary boundary, Window& copy) {
  const Index n = index_of(signal.size());
  return window_of(signal, first, count, copy, [&](Index i) { return place_in_signal(i, n, boundary); });
}

/// Coefficients repeat in periodization; in symmetric mode none beyond the ends is asked for.
const double* coefficient_window(std::span<const double> coefficients, Index first, Index count, Window& copy) {
  const Index n = index_of(coefficients.size());
  return window_of(coefficients, first, count, copy, [&](Index i) { return modulo(i, n); });
}

/// Writes even[0], odd[0], even[1].. from place `first` of the signal on, leaving out what lies outside.
void interleave_into(std::span<double> signal, Index first, Index pairs, const Channel& even, const Channel& odd) {
  const Index n = index_of(signal.size());
  if (first >= 0 && first + 2 * pairs <= n) {
    interleave(static_cast<std::size_t>(pairs), even.data(), odd.data(), signal.data() + first);
    return;
  }
  Window both;
  interleave(static_cast<std::size_t>(pairs), even.data(), odd.data(), both.data());
  const Index skipped = std::max<Index>(-first, 0);
  const Index end = std::min(2 * pairs, n - first);
  std::copy(both.data() + skipped, both.data() + end, signal.data() + first + skipped);
}

}  // namespace

base::Status check_filters(const Wavelet& wavelet) {
  const std::size_t length = wavelet.length();
  const bool usable = length >= 2 && length <= kMaxLength && length % 2 == 0;
  const auto same = [&](const std::vector<double>& filter) { return filter.size() == length; };
  if (usable && same(wavelet.dec_hi) && same(wavelet.rec_lo) && same(wavelet.rec_hi)) return {};
  return base::bad_input("a wavelet needs four filters of one even length from 2 to " + std::to_string(kMaxLength),
                         "wavelet '" + wavelet.name + "'");
}

base::Status check_not_negative(std::span<const double> values, std::string_view what) {
  for (std::size_t j = 0; j < values.size(); ++j) {
    if (std::isfinite(values[j]) && values[j] >= 0.0) continue;
    return base::bad_input(fmt::format("{} is {}; it must be finite and at least 0", what, values[j]),
                           fmt::format("level {}", j + 1));
  }
  return {};
}

Banks banks_of(const Wavelet& wavelet) {
  Banks banks;
  banks.length = wavelet.length();
  const std::size_t taps = banks.length / 2;
  banks.analysis.taps = banks.synthesis.taps = taps;
  const auto& lo = wavelet.rec_lo;
  const auto& hi = wavelet.rec_hi;
  for (std::size_t t = 0; t < taps; ++t) {
    const std::size_t r = banks.length - 2 - 2 * t;
    banks.analysis.tap[t] = {lo[2 * t], lo[2 * t + 1], hi[2 * t], hi[2 * t + 1]};
    banks.synthesis.tap[t] = {lo[r], hi[r], lo[r + 1], hi[r + 1]};
  }
  return banks;
}

std::size_t coefficient_count(std::size_t samples, std::size_t length, Boundary boundary) {
  return boundary == Boundary::periodization ? (samples + 1) / 2 : (samples + length - 1) / 2;
}

// With the filters reversed, a[o] = sum over i of rec_lo[i] x[2 o + s + i], d[o] alike with rec_hi; in symmetric mode
// s = 2 - F, in periodization s = 1 - F/2. Even and odd places are the two input channels.
void analyse(std::span<const double> signal, const Banks& banks, Boundary boundary, double* approximation,
             double* detail) {
  const Index length = index_of(banks.length);
  const Index shift = boundary == Boundary::periodization ? 1 - length / 2 : 2 - length;
  const Index total = index_of(coefficient_count(signal.size(), banks.length, boundary));
  Window copy;
  Channel even;
  Channel odd;
  for (Index o = 0; o < total; o += kBlock) {
    const Index count = std::min(kBlock, total - o);
    const Index pairs = count + length / 2 - 1;
    deinterleave(static_cast<std::size_t>(pairs), signal_window(signal, 2 * o + shift, 2 * pairs, boundary, copy),
                 even.data(), odd.data());
    filter_bank(static_cast<std::size_t>(count), banks.analysis, even.data(), odd.data(), approximation + o,
                detail + o);
  }
}

// x[2 q + s] = sum over t of rec_lo[2 t] a[q - t] + rec_hi[2 t] d[q - t], x[2 q + 1 + s] alike with the odd taps, s as
// in analyse().
void synthesise(std::span<const double> approximation, std::span<const double> detail, const Banks& banks,
                Boundary boundary, std::span<double> signal) {
  const Index taps = index_of(banks.length / 2);
  const Index shift = boundary == Boundary::periodization ? 1 - taps : 2 - 2 * taps;
  const Index end = (index_of(signal.size()) - 1 - shift) / 2 + 1;
  Window low;
  Window high;
  Channel even;
  Channel odd;
  for (Index q = -shift / 2; q < end; q += kBlock) {
    const Index count = std::min(kBlock, end - q);
    const Index window = count + taps - 1;
    const Index first = q - taps + 1;
    filter_bank(static_cast<std::size_t>(count), banks.synthesis, coefficient_window(approximation, first, window, low),
                coefficient_window(detail, first, window, high), even.data(), odd.data());
    interleave_into(signal, 2 * q + shift, count, even, odd);
  }
}

}  // namespace soak::calib::signal::wavelet
