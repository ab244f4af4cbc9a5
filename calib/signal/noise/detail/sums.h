// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "base/instruction_set.h"

namespace soak::calib::signal {

/// Interleaved partial sums of the additions below: an order that the compiler can keep in vector registers.
inline constexpr std::size_t kSumLanes = 8;

/// Sum of term(i), i = 0..n - 1.
template <class Term>
[[nodiscard]] SOAK_INLINE double lane_sum(std::size_t n, const Term& term) {
  std::array<double, kSumLanes> partial{};
  std::size_t i = 0;
  for (; i + kSumLanes <= n; i += kSumLanes) {
    for (std::size_t lane = 0; lane < kSumLanes; ++lane) partial[lane] += term(i + lane);
  }
  for (; i < n; ++i) partial[0] += term(i);
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

/// sum_i a_i b_i, both of the same length.
[[nodiscard]] SOAK_INLINE double product_sum(std::span<const double> a, std::span<const double> b) {
  return lane_sum(a.size(), [&](std::size_t i) { return a[i] * b[i]; });
}

}  // namespace soak::calib::signal
