// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/kernels.h"

#include <algorithm>

#include "base/instruction_set.h"

namespace soak::calib::signal::allan {
namespace {

constexpr std::size_t kLanes = 16;
constexpr std::size_t kChains = 8;
constexpr std::size_t kStrip = 512;  ///< windows whose steps are kept at a time: 4 KB

struct SecondDifference {
  const double* x;
  std::size_t m;
  SOAK_INLINE double operator()(std::size_t i) const { return (x[i + 2 * m] - x[i + m]) - (x[i + m] - x[i]); }
};

struct ThirdDifference {
  const double* x;
  std::size_t m;
  SOAK_INLINE double operator()(std::size_t i) const {
    const double middle = x[i + 2 * m] - x[i + m];
    return ((x[i + 3 * m] - x[i + 2 * m]) - middle) - (middle - (x[i + m] - x[i]));
  }
};

template <class Term>
struct Square {
  Term term;
  SOAK_INLINE double operator()(std::size_t i) const {
    const double value = term(i);
    return value * value;
  }
};

template <std::size_t kCount>
SOAK_INLINE double tree_sum(double (&lanes)[kCount]) {
  for (std::size_t half = kCount / 2; half > 0; half /= 2) {
    for (std::size_t k = 0; k < half; ++k) lanes[k] += lanes[k + half];
  }
  return lanes[0];
}

/// Sum over i < count of term(i).
template <class Term>
SOAK_INLINE double lane_sum(Term term, std::size_t count) {
  double lanes[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) lanes[k] += term(i + k);
  }
  for (std::size_t k = 0; i < count; ++i, ++k) lanes[k] += term(i);
  return tree_sum(lanes);
}

/// values[i] <- values[i] + values[i + distance], i < count
SOAK_INLINE void add_shifted(double* values, std::size_t distance, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] += values[i + distance];
}

/// W_i = T_i + .. + T_{i+7}, i < count: neighbours, then pairs, then fours.
SOAK_INLINE void window_steps(ThirdDifference step, std::size_t first, std::size_t count, double* w) {
  for (std::size_t i = 0; i < count + 7; ++i) w[i] = step(first + i);
  add_shifted(w, 1, count + 6);
  add_shifted(w, 2, count + 4);
  add_shifted(w, 4, count);
}

/// S <- S + W, and the sums of S^2, eight chains side by side.
SOAK_INLINE void advance(const double* w, std::size_t count, double (&s)[kChains], double (&squares)[kChains]) {
  std::size_t i = 0;
  for (; i + kChains <= count; i += kChains) {
    for (std::size_t k = 0; k < kChains; ++k) {
      s[k] += w[i + k];
      squares[k] += s[k] * s[k];
    }
  }
  for (std::size_t k = 0; i < count; ++i, ++k) {
    s[k] += w[i];
    squares[k] += s[k] * s[k];
  }
}

}  // namespace

SOAK_CLONES double second_differences(const double* x, std::size_t m, std::size_t starts) {
  return lane_sum(Square<SecondDifference>{{x, m}}, starts);
}

SOAK_CLONES double third_differences(const double* x, std::size_t m, std::size_t starts) {
  return lane_sum(Square<ThirdDifference>{{x, m}}, starts);
}

SOAK_CLONES double modified_differences(const double* x, std::size_t m, std::size_t starts) {
  if (starts == 0) return 0.0;
  const ThirdDifference step{x, m};
  double s[kChains] = {lane_sum(SecondDifference{x, m}, m)};
  double squares[kChains] = {s[0] * s[0]};
  for (std::size_t k = 1; k < std::min(kChains, starts); ++k) {
    s[k] = s[k - 1] + step(k - 1);
    squares[k] = s[k] * s[k];
  }
  double w[kStrip + kChains];
  for (std::size_t first = 0; first + kChains < starts; first += kStrip) {
    const std::size_t count = std::min(kStrip, starts - kChains - first);
    window_steps(step, first, count, w);
    advance(w, count, s, squares);
  }
  return tree_sum(squares);
}

}  // namespace soak::calib::signal::allan
