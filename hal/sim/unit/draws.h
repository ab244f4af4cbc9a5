// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/random.h"
#include "calib/vocabulary/position.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {

/// What a random number is for. Kept apart so that one draw more for one purpose moves no other; never renumber.
enum class Purpose : std::uint64_t {
  unit = 1,
  run = 2,
  bias_curve = 3,
  scale_curve = 4,
  axes = 5,
  power_on = 6,
  visit = 7,
  white_noise = 8,
  slow_noise = 9,
  thermometer = 10,
  chamber = 11,
  lab_white_noise = 12,
  lab_slow_noise = 13,
  lab_thermometer = 14,
  lab_chamber_sensor = 15,
  lab_unit = 16,
  hidden_sensors = 17,
  hidden_shape = 18,
  hidden_chance = 19,
  hidden_strength = 20,
  design_profile = 21,
  design_visit = 22,
  design_noise = 23,
  design_placement = 24,
  design_visit_scatter = 25,
  design_thermometer = 26,
  design_chamber = 27,
  design_mistake = 28,
  compressor = 29,
  supply = 30,
};

/// Stream number of the `member`-th (below 2^32) sensor, process... that a purpose has.
constexpr std::uint64_t stream_of(Purpose purpose, std::uint64_t member = 0) {
  return (static_cast<std::uint64_t>(purpose) << 32) | member;
}

inline double drawn_from(base::Random& random, Range range) { return random.uniform(range.low, range.high); }

inline double drawn_within(base::Random& random, double half_width) { return random.uniform(-half_width, half_width); }

inline double drawn_sign(base::Random& random) { return random.uniform() < 0.5 ? -1.0 : 1.0; }

/// Unit vector, the same chance for every direction.
inline calib::Vector3 drawn_direction(base::Random& random) {
  const double height = random.uniform(-1.0, 1.0);
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double radius = std::sqrt(1.0 - height * height);
  return {radius * std::cos(angle), radius * std::sin(angle), height};
}

/// Whole number from `range.low` to `range.high`, both possible.
inline int drawn_count(base::Random& random, Range range) {
  return static_cast<int>(std::floor(random.uniform(range.low, range.high + 1.0)));
}

}  // namespace soak::hal::sim
