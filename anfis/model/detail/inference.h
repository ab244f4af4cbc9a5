// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "anfis/model/model.h"
#include "base/instruction_set.h"

namespace soak::anfis::inference {

// --- Exponential and logarithm without branches: loops over them vectorise, and they give the same bits everywhere,
// which no two mathematics libraries promise.

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

// --- Membership functions through the logarithm of their degree: it never underflows, its derivatives stay finite
// where the degree does, and the product of degrees becomes a sum. `distance` is what a shape measures from its centre:
// ln t^2 for the bell, t^2 for Gaussians, with t = (u - centre) / width.

/// Keeps every power and product finite; no input of a real model comes near so many half ranges.
inline constexpr double kFarthest = 1e50;
/// Stands for ln 0 inside a triangle's or trapezoid's support, and for its distance outside: see log_degree().
inline constexpr double kNeverFires = -1e6;

SOAK_INLINE double bell_distance(double u, double width, double centre) {
  const double t = (u - centre) / width;
  return logarithm(t * t);
}

SOAK_INLINE double gaussian_distance(double u, double width, double centre) {
  const double t = (u - centre) / width;
  return t * t;
}

/// [AH05 eq. 5.6] 1 / (1 + (t^2)^b)
SOAK_INLINE double bell_degree(double distance, double slope) { return 1.0 / (1.0 + exponential(slope * distance)); }

/// [AH05 eq. 5.7] exp(-t^2 / 2)
SOAK_INLINE double gaussian_degree(double distance) { return exponential(-0.5 * distance); }

/// ln of the bell's degree: -ln(1 + z), z = (t^2)^b.
SOAK_INLINE double bell_log_degree(double distance, double slope) {
  const double power = slope * distance;
  return power > 0.0 ? -power - logarithm(1.0 + exponential(-power)) : -logarithm(1.0 + exponential(power));
}

/// d ln mu / d (width, slope, centre) of the bell. ln mu = -ln(1 + z), so d ln mu / d ln t = -2 b (1 - mu); where
/// 1 - mu is 0 (at the centre) all are 0.
SOAK_INLINE std::array<double, 3> bell_log_derivatives(double u, double distance, double degree, double width,
                                                       double slope, double centre) {
  const double rest = 1.0 - degree;
  const double offset = u - centre;
  const double safe_offset = offset == 0.0 ? 1.0 : offset;
  return {2.0 * slope * rest / width, -rest * distance, offset == 0.0 ? 0.0 : 2.0 * slope * rest / safe_offset};
}

/// d ln mu / d (width, centre) of the Gaussian.
SOAK_INLINE std::array<double, 2> gaussian_log_derivatives(double u, double distance, double width, double centre) {
  return {distance / width, (u - centre) / (width * width)};
}

// --- Firing strengths that underflow.

/// Below this sum of firing strengths the strengths may be zero or rough: their logarithms decide.
inline constexpr double kSmallestSum = 1e-200;

/// Normalises logarithms of firing strengths in place: their largest one becomes the measure.
void normalise_logarithms(std::span<double> log_strengths);

/// ln w of a rule at the scaled inputs u: the sum or the least of the logarithms of its degrees.
[[nodiscard]] double log_strength(const Model& model, const Rule& rule, std::span<const double> u);

}  // namespace soak::anfis::inference
