// SPDX-License-Identifier: Apache-2.0
// The memory that a device follows in float32, against that of the simulation: two code paths for one definition
// (docs/gap-terms.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"
#include "calib/forward/thermal_history.h"
#include "calib/runtime/soak_history.h"

namespace soak::calib::forward {
namespace {

constexpr std::array<double, 6> kWidths_c = {2.0, 6.0, 15.0, 15.0, 35.0, 70.0};

/// A device whose sensors remember over these widths.
soak_history device() {
  soak_history history{};
  for (std::size_t i = 0; i < kWidths_c.size(); ++i) history.width_c[i] = static_cast<float>(kWidths_c[i]);
  soak_history_start(&history, 0.0F);
  return history;
}

/// Ways between random temperatures at random speeds, with rests, and noise of a thermometer on top.
Series random_path(std::uint64_t seed, double noise_c) {
  base::Random random(seed);
  Series path;
  double temp_c = -20.0 + 80.0 * random.uniform();
  for (int way = 0; way < 12; ++way) {
    const double to_c = -40.0 + 125.0 * random.uniform();
    const double step_c = 0.001 + (way % 3 == 0 ? 0.5 : 0.05) * random.uniform();
    const double sign = to_c > temp_c ? 1.0 : -1.0;
    while (sign * (to_c - temp_c) > 0.0) {
      temp_c += sign * step_c;
      path.values.push_back(temp_c + noise_c * (random.uniform() - 0.5));
    }
    const double rest = 50.0 * random.uniform();
    for (int k = 0; k < static_cast<int>(rest); ++k) path.values.push_back(temp_c + noise_c * (random.uniform() - 0.5));
  }
  for (std::size_t k = 0; k < path.values.size(); ++k) path.t_s.push_back(static_cast<double>(k));
  return path;
}

/// A way of less than the runtime's least waits, and where it turns is not made up for, once up and once down; the
/// distance from the way's sign is at most 2. And the rounding of float32, 6e-8 a step in ways of 0.002 K / width: less
/// than two thousandths of the way, at most 2/e of it at a time.
double tolerance(double width_c) { return 4.0 * static_cast<double>(SOAK_LEAST_WAY_C) / width_c + 1.5e-3; }

void expect_alike(const Series& path, soak_history& history, double start) {
  std::array<Series, 6> simulated;
  for (std::size_t i = 0; i < 6; ++i) simulated.at(i) = branch_memory_of(path, kWidths_c.at(i), start);
  for (std::size_t k = 0; k < path.values.size(); ++k) {
    ASSERT_EQ(soak_history_step(&history, static_cast<float>(path.values[k])), SOAK_OK);
    for (std::size_t i = 0; i < 6; ++i) {
      ASSERT_NEAR(static_cast<double>(history.state.memory[i]), simulated.at(i).values[k], tolerance(kWidths_c.at(i)))
          << "row " << k << ", width " << kWidths_c.at(i);
    }
  }
}

TEST(DeviceHistory, FollowsRandomPathsAsTheSimulationDoes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    soak_history history = device();
    expect_alike(random_path(seed, 0.0), history, 0.0);
  }
}

TEST(DeviceHistory, TakesNoNoiseWithinTheDeadBandForTurns) {
  for (std::uint64_t seed = 31; seed <= 36; ++seed) {
    soak_history history = device();
    expect_alike(random_path(seed, 0.2), history, 0.0);
  }
}

TEST(DeviceHistory, ToldItsBranchStartsOnIt) {
  for (std::uint64_t seed = 51; seed <= 56; ++seed) {
    const Series path = random_path(seed, 0.0);
    const Series from_room = branch_memory_of(path, 15.0);
    soak_history history = device();
    soak_history_start(&history, static_cast<float>(from_room.values.front()));
    for (std::size_t k = 0; k < path.values.size(); ++k) {
      ASSERT_EQ(soak_history_step(&history, static_cast<float>(path.values[k])), SOAK_OK);
      ASSERT_NEAR(static_cast<double>(history.state.memory[2]), from_room.values[k], tolerance(15.0)) << k;
    }
  }
}

/// Rows of the thermometer that are not there are left out of the simulation's series too: what is between is one way.
TEST(DeviceHistory, CountsGapsAsOneWay) {
  Series path = random_path(71, 0.0);
  Series holed;
  for (std::size_t k = 0; k < path.values.size(); ++k) {
    if (k % 1000 > 100 && k % 1000 < 700) continue;
    holed.t_s.push_back(path.t_s[k]);
    holed.values.push_back(path.values[k]);
  }
  const Series simulated = branch_memory_of(holed, 6.0, 0.0);
  soak_history history = device();
  std::size_t row = 0;
  for (std::size_t k = 0; k < path.values.size(); ++k) {
    const bool hole = k % 1000 > 100 && k % 1000 < 700;
    const float read_c = hole ? std::nanf("") : static_cast<float>(path.values[k]);
    ASSERT_EQ(soak_history_step(&history, read_c), hole ? SOAK_INVALID : SOAK_OK);
    if (hole) continue;
    ASSERT_NEAR(static_cast<double>(history.state.memory[1]), simulated.values[row++], tolerance(6.0)) << k;
  }
}

TEST(DeviceHistory, OfAWrongStartForgetsItAsItsBoundSays) {
  const Series path = random_path(91, 0.0);
  for (const double truth : {-1.0, 1.0}) {
    soak_history history = device();
    const double first = branch_memory_of(path, 15.0, 1.0).values.front();
    const Series simulated = branch_memory_of(path, 15.0, truth * first);
    for (std::size_t k = 0; k < path.values.size(); ++k) {
      ASSERT_EQ(soak_history_step(&history, static_cast<float>(path.values[k])), SOAK_OK);
      const double off = std::abs(static_cast<double>(history.state.memory[2]) - simulated.values[k]);
      ASSERT_LE(off, static_cast<double>(history.state.unknown[2]) + tolerance(15.0)) << k;
    }
    EXPECT_LT(history.state.unknown[2], 1e-3F);
  }
}

}  // namespace
}  // namespace soak::calib::forward
