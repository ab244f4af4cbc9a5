// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "base/instruction_set.h"

// Exponential and logarithm without branches: loops over them vectorise, and they give the same bits everywhere, which
// no two mathematics libraries promise.
namespace soak::anfis::inference {

inline constexpr double kLn2High = 0x1.62e42fefa3p-1;  ///< 41 bits: its product with an exponent is exact
inline constexpr double kLn2Low = 0x1.3de6af278ece6p-42;

/// e^x, relative error below 4e-16; x is limited to [-708, 709], where the result is normal.
SOAK_INLINE double exponential(double x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer, which then stands in the low bits
  constexpr double kLog2E = 0x1.71547652b82fep+0;
  x = x < -708.0 ? -708.0 : x;
  x = x > 709.0 ? 709.0 : x;
  // x = n ln 2 + r, |r| <= ln(2) / 2
  const double shifted = x * kLog2E + kRound;
  const double n = shifted - kRound;
  const double r = (x - n * kLn2High) - n * kLn2Low;
  // Taylor series of e^r: the first term left out is below 4e-18.
  const double r2 = r * r;
  const double r4 = r2 * r2;
  const double low = (1.0 + r) + (0.5 + r * (1.0 / 6.0)) * r2;
  const double middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + (1.0 / 720.0 + r * (1.0 / 5040.0)) * r2;
  const double high = (1.0 / 40320.0 + r * (1.0 / 362880.0)) + (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) * r2;
  const double highest = 1.0 / 479001600.0 + r * (1.0 / 6227020800.0);
  const double p = low + (middle + (high + highest * r4) * r4) * r4;
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(p) + (std::bit_cast<std::uint64_t>(shifted) << 52));
}

/// Natural logarithm of x, absolute error below 2e-16 (1 + |ln x|); x is limited to [2.3e-308, 1.7e308].
SOAK_INLINE double logarithm(double x) {
  constexpr std::uint64_t kHalfRoot = 0x3fe6a09e667f3bcdU;  // bits of sqrt(1/2)
  constexpr std::uint64_t kOne = 0x3ff0000000000000U;
  constexpr std::uint64_t kMantissa = 0x000fffffffffffffU;
  constexpr std::uint64_t kTwo52 = 0x4330000000000000U;  // 2^52, whose low bits count in ones
  x = x < 2.3e-308 ? 2.3e-308 : x;
  x = x > 1.7e308 ? 1.7e308 : x;
  // x = 2^n m, sqrt(1/2) <= m < sqrt(2)
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) + (kOne - kHalfRoot);
  const double n = std::bit_cast<double>((bits >> 52) | kTwo52) - (0x1p52 + 1023.0);
  const double m = std::bit_cast<double>((bits & kMantissa) + kHalfRoot);
  // ln m = 2 artanh(s), s = (m - 1) / (m + 1), |s| < 0.172: the first term left out is below 2e-18.
  const double s = (m - 1.0) / (m + 1.0);
  const double z = s * s;
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double low = (1.0 + z * (1.0 / 3.0)) + (1.0 / 5.0 + z * (1.0 / 7.0)) * z2;
  const double middle = (1.0 / 9.0 + z * (1.0 / 11.0)) + (1.0 / 13.0 + z * (1.0 / 15.0)) * z2;
  const double high = (1.0 / 17.0 + z * (1.0 / 19.0)) + (1.0 / 21.0) * z2;
  const double p = low + (middle + high * z4) * z4;
  return n * kLn2High + (2.0 * s * p + n * kLn2Low);
}

}  // namespace soak::anfis::inference
