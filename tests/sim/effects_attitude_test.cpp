// SPDX-License-Identifier: Apache-2.0
// Effects that the position drives, each against its physics.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "tests/sim/effect_support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;
using calib::Vector3;
using test::at_rest;
using test::LoneEffect;

constexpr std::array<Vector3, 6> kUps = {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
constexpr std::array<Sensor, 3> kGyros = {Sensor::gyro_x, Sensor::gyro_y, Sensor::gyro_z};
constexpr std::array<Sensor, 3> kAccels = {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z};
constexpr double kG_mps2 = 9.80665;

/// Responses of three sensors at rest.
Vector3 responses(LoneEffect& effect, const Vector3& up, const std::array<Sensor, 3>& sensors, double temp_c = 25.0) {
  effect.effect->advance_to(at_rest(0.0, temp_c, up));
  return {effect.effect->response(sensors[0]), effect.effect->response(sensors[1]),
          effect.effect->response(sensors[2])};
}

TEST(GSensitivity, IsTheMatrixOfTheTruthTimesTheForceInG) {
  std::set<bool> all_axes;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    LoneEffect effect("g_sensitivity", 1.0, seed);
    double largest = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vector3 up{};
      up[axis] = 1.0;
      const Vector3 plus = responses(effect, up, kGyros);
      up[axis] = -1.0;
      const Vector3 minus = responses(effect, up, kGyros);
      for (std::size_t gyro = 0; gyro < 3; ++gyro) {
        EXPECT_EQ(plus[gyro], effect.shape(std::string("m_") + "xyz"[gyro] + "xyz"[axis]));
        EXPECT_EQ(minus[gyro], -plus[gyro]);
        largest = std::max(largest, std::abs(plus[gyro]));
        if (axis != gyro) all_axes.insert(plus[gyro] != 0.0);
      }
      EXPECT_EQ(responses(effect, up, kAccels), Vector3{});
    }
    EXPECT_EQ(largest, 1.0);
  }
  EXPECT_EQ(all_axes.size(), 2U) << "some matrices are diagonal, some full";
}

TEST(EarthRate, IsOneRotationWhosePartAlongUpIsTheSineOfTheLatitude) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    LoneEffect effect("earth_rate", 1.0, seed);
    const double sine = std::sin(effect.shape("latitude_deg") * std::numbers::pi / 180.0);
    for (const Vector3& up : kUps) {
      const Vector3 rate = responses(effect, up, kGyros);
      EXPECT_NEAR(rate[0] * up[0] + rate[1] * up[1] + rate[2] * up[2], sine, 1e-12);
      EXPECT_NEAR(rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2], 1.0, 1e-12);
    }
  }
}

TEST(CrossAxis, GrowsInProportionToTheKelvinsAbove25AndNeverAlongTheAxis) {
  LoneEffect effect("cross_axis");
  for (const Vector3& up : kUps) {
    EXPECT_EQ(responses(effect, up, kAccels, 25.0), Vector3{});
    const Vector3 warm = responses(effect, up, kAccels, 35.0);
    const Vector3 cold = responses(effect, up, kAccels, -5.0);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(cold[i], -3.0 * warm[i], 1e-9);
      if (up[i] != 0.0) {
        EXPECT_EQ(warm[i], 0.0);
      } else {
        EXPECT_GE(std::abs(warm[i]), 0.5 * 10.0 * kG_mps2);
      }
    }
  }
}

TEST(FixtureTilt, IsOneSmallRotationPerMounting) {
  LoneEffect effect("fixture_tilt");
  const auto tilted = [&](const Vector3& up, int mounting, double temp_c) {
    Conditions now = at_rest(0.0, temp_c, up);
    now.mounting = mounting;
    effect.effect->advance_to(now);
    return Vector3{effect.effect->response(kAccels[0]), effect.effect->response(kAccels[1]),
                   effect.effect->response(kAccels[2])};
  };
  const Vector3 on_x = tilted(kUps[0], 0, 25.0);
  const Vector3 on_y = tilted(kUps[2], 0, 25.0);
  EXPECT_EQ(on_x[0], 0.0) << "a small rotation turns a vector sideways";
  EXPECT_NEAR(on_x[1], -on_y[0], 1e-12) << "and is antisymmetric";
  EXPECT_EQ(tilted(kUps[0], 0, 70.0), on_x);
  EXPECT_NE(tilted(kUps[0], 1, 25.0), on_x);
  double squares = 0.0;
  for (int mounting = 0; mounting < 400; ++mounting) {
    const Vector3 shift = tilted(kUps[0], mounting, 25.0);
    squares += shift[1] * shift[1] + shift[2] * shift[2];
  }
  // Two of three parts of an angle of 1 degree; 4 standard errors of a mean of 800 squares are 20 %.
  const double expected = 2.0 / 3.0 * std::pow(kG_mps2 * std::numbers::pi / 180.0, 2.0);
  EXPECT_NEAR(squares / 400.0, expected, 0.2 * expected);
}

TEST(ScaleNonlinearity, ReadsTheSameUpAndDownAndNothingSideways) {
  LoneEffect effect("scale_nonlinearity");
  EXPECT_EQ(responses(effect, kUps[0], kAccels), (Vector3{1.0, 0.0, 0.0}));
  EXPECT_EQ(responses(effect, kUps[1], kAccels), (Vector3{1.0, 0.0, 0.0}));
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(responses(effect, {half, half, 0.0}, kAccels)[0], 0.5, 1e-12);
}

TEST(RepositionCreep, BeginsWithATurnAndDecaysWithItsTimeConstant) {
  LoneEffect effect("reposition_creep");
  const double decay_s = effect.shape("decay_s");
  EXPECT_EQ(effect.at(at_rest(0.0, 25.0, kUps[4])), 0.0);
  EXPECT_EQ(effect.at(at_rest(1000.0, 25.0, kUps[4])), 0.0);
  const double turned = effect.at(at_rest(1020.0, 25.0, kUps[5]));
  EXPECT_NE(turned, 0.0);
  EXPECT_NEAR(effect.at(at_rest(1020.0 + decay_s, 25.0, kUps[5])), turned / std::numbers::e, 1e-12);
  EXPECT_NEAR(effect.at(at_rest(1020.0 + 40 * decay_s, 25.0, kUps[5])), 0.0, 1e-12);
}

TEST(PositionMemory, DependsOnThePositionBeforeAndStays) {
  const auto after = [](const Vector3& before) {
    LoneEffect effect("position_memory");
    effect.at(at_rest(0.0, 25.0, before));
    effect.at(at_rest(10.0, 25.0, {std::sqrt(0.5), 0.0, std::sqrt(0.5)}));  // on the way
    const double value = effect.at(at_rest(20.0, 25.0, kUps[2]));
    EXPECT_EQ(effect.at(at_rest(5000.0, 70.0, kUps[2])), value);
    return value;
  };
  EXPECT_EQ(after(kUps[0]), -after(kUps[1]));
  EXPECT_NE(after(kUps[0]), after(kUps[4]));
}

TEST(PositionMemory, AHalfTurnDoesNotRestOnTheAxisThatItPasses) {
  const auto turned_over = [](bool sampled_on_the_axis) {
    LoneEffect effect("position_memory");
    for (double t_s = 0.0; t_s <= 100.0; t_s += 0.1) effect.at(at_rest(t_s, 25.0, kUps[0]));
    const double half = std::sqrt(0.5);
    effect.at(at_rest(102.5, 25.0, {half, half, 0.0}));
    if (sampled_on_the_axis) effect.at(at_rest(105.0, 25.0, {0.0, 1.0, 0.0}));
    effect.at(at_rest(105.1, 25.0, {-0.03, std::sqrt(1.0 - 0.0009), 0.0}));
    return effect.at(at_rest(110.0, 25.0, kUps[1]));
  };
  EXPECT_EQ(turned_over(true), turned_over(false));
  EXPECT_NE(turned_over(true), 0.0);
}

}  // namespace
}  // namespace soak::hal::sim
