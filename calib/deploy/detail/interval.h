// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace soak::calib::table {

/// All numbers from low to high; low <= high. The operations give the range of the results, up to the rounding of
/// double precision.
struct Interval {
  double low = 0.0;
  double high = 0.0;

  /// Largest magnitude.
  [[nodiscard]] double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
};

inline Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
inline Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
inline Interval operator+(Interval a, double b) { return {a.low + b, a.high + b}; }
inline Interval operator-(Interval a, double b) { return {a.low - b, a.high - b}; }
inline Interval operator*(double k, Interval a) {
  return k < 0.0 ? Interval{k * a.high, k * a.low} : Interval{k * a.low, k * a.high};
}
inline Interval operator*(Interval a, Interval b) {
  const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
  return {low, high};
}

}  // namespace soak::calib::table
