// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/noise/noise.h"

// Records of noise of known coefficients, their curves and fits.
namespace soak::calib::signal::allan_fit_support {

using Samples = std::vector<double>;

inline Samples operator+(Samples a, const Samples& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

/// On the averaging times that `soak signal allan` prints.
inline AllanCurve curve_of(const Samples& rate, double rate_hz = 1.0) {
  const auto record = PhaseRecord::from_rate(rate, rate_hz);
  EXPECT_TRUE(record);
  AllanCurve curve{.interval_s = record->interval_s()};
  for (const Stretch& stretch : record->stretches()) curve.stretches.push_back(stretch.count);
  curve.multiples = log_spaced_multiples(2 * record->longest(AllanKind::overlapping) / 3, 12);
  for (const AllanPoint& point : allan_points(*record, AllanKind::overlapping, curve.multiples)) {
    curve.deviation.push_back(point.deviation);
  }
  return curve;
}

inline bool holds(const AllanCoefficient& coefficient, double truth) {
  return coefficient.low <= truth && truth <= coefficient.high;
}

inline AllanFit truth_of(double white, double flicker, double walk) {
  AllanFit truth;
  truth.angle_random_walk.value = white;
  truth.flicker.value = flicker;
  truth.rate_random_walk.value = walk;
  return truth;
}

inline Samples noise_of(const AllanFit& truth, std::size_t count, std::uint64_t seed) {
  const NoiseSource source{.rate_hz = 1.0, .seed = seed};
  return white_noise(count, truth.angle_random_walk.value, source) + flicker_noise(count, truth.flicker.value, source) +
         random_walk(count, truth.rate_random_walk.value, source);
}

/// White noise with a line a hundred times above it in variance.
inline AllanCurve curve_with_a_line() {
  Samples rate = white_noise(40000, 0.1 / std::sqrt(200.0), {.rate_hz = 200.0, .seed = 21});
  for (std::size_t i = 0; i < rate.size(); ++i) {
    rate[i] += std::sin(2.0 * std::numbers::pi * 17.3 / 200.0 * static_cast<double>(i));
  }
  return curve_of(rate, 200.0);
}

}  // namespace soak::calib::signal::allan_fit_support
