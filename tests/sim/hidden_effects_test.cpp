// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/hidden_effects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "tests/sim/effect_support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;
using test::at_rest;

HiddenSpec spec_of(const std::string& effect, std::optional<double> magnitude, std::optional<double> amplitude,
                   std::uint64_t seed = 1) {
  return {effect, magnitude, amplitude, seed, {}};
}

TEST(DrawnEffect, HitsOneThreeOrAllSensorsAsItsPhysicsAllows) {
  for (const CatalogueEntry& entry : catalogue()) {
    std::map<std::size_t, int> counts;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const DrawnEffect drawn = draw_effect(spec_of(std::string(entry.name), 1.0, {}, seed), 1, 0.5);
      ++counts[drawn.sensors.size()];
      for (const Sensor sensor : calib::kSensors) {
        const bool hit = std::count(drawn.sensors.begin(), drawn.sensors.end(), sensor) > 0;
        EXPECT_EQ(hit, drawn.weight[calib::index_of(sensor)] != 0.0);
        EXPECT_TRUE(!hit || can_hit(entry.hits, sensor)) << entry.name;
      }
    }
    std::set<std::size_t> sizes;
    for (const auto& [size, count] : counts) sizes.insert(size);
    const bool alike = !can_choose_sensors(entry.hits);
    if (entry.hits == Hits::some) {
      EXPECT_EQ(sizes, (std::set<std::size_t>{1, 3, 6})) << entry.name;
    } else if (alike) {
      EXPECT_EQ(sizes, (std::set<std::size_t>{entry.hits == Hits::all ? 6U : 3U})) << entry.name;
    } else {
      EXPECT_EQ(sizes, (std::set<std::size_t>{1, 3})) << entry.name;
    }
  }
}

TEST(DrawnEffect, WeighsSensorsBetweenAHalfAndOneAndAccelerometersByTheirNoise) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const DrawnEffect drawn = draw_effect(spec_of("supply_sensitivity", 1.0, {}, seed), 1, 0.25);
    double largest = 0.0;
    for (const Sensor sensor : drawn.sensors) {
      const bool beside_gyros = calib::is_gyro(drawn.sensors.front()) && !calib::is_gyro(sensor);
      const double weight = std::abs(drawn.weight[calib::index_of(sensor)]) / (beside_gyros ? 0.25 : 1.0);
      EXPECT_GE(weight, 0.5);
      largest = std::max(largest, weight);
    }
    EXPECT_DOUBLE_EQ(largest, 1.0);
  }
}

TEST(DrawnEffect, GivesEverySensorTheAmplitudeThatIsStated) {
  HiddenSpec spec = spec_of("supply_sensitivity", {}, -0.3);
  spec.sensors = {Sensor::gyro_z, Sensor::gyro_x};
  const DrawnEffect drawn = draw_effect(spec, 1, 0.5);
  EXPECT_EQ(drawn.sensors, (std::vector<Sensor>{Sensor::gyro_x, Sensor::gyro_z}));
  EXPECT_EQ(amplitude_of(drawn, Sensor::gyro_x, -0.3), -0.3);
  EXPECT_EQ(amplitude_of(drawn, Sensor::gyro_y, -0.3), 0.0);
}

TEST(HiddenEffects, ChangeNothingWhereThereAreNone) {
  HiddenEffects effects;
  effects.advance_to(at_rest(5.0, 33.0));
  EXPECT_EQ(effects.element_c(), 33.0);
  EXPECT_EQ(effects.output(Sensor::gyro_x, effects.sensed(Sensor::gyro_x, 0.1, 0.02)), 0.1 + 0.02);
}

TEST(HiddenEffects, AddInSiUnitsWhatIsStatedInPrintedOnes) {
  HiddenEffects effects;
  HiddenSpec spec = spec_of("supply_sensitivity", {}, 2.0);
  spec.sensors = {Sensor::gyro_y, Sensor::accel_x};
  effects.add(draw_effect(spec, 1, 0.5), 2.0, {});
  Conditions now = at_rest(0.0, 25.0);
  now.supply_v = 5.5;
  effects.advance_to(now);
  EXPECT_NEAR(effects.sensed(Sensor::gyro_y, 0.0, 0.0), 1.0 * base::kRadPerDeg, 1e-12);
  EXPECT_NEAR(effects.sensed(Sensor::accel_x, 0.0, 0.0), 0.5, 1e-12) << "half of it, by the noise of its kind";
  EXPECT_EQ(effects.sensed(Sensor::gyro_x, 0.0, 0.0), 0.0);
}

TEST(HiddenEffects, WarmTheElementsBeforeOthersFeelTheirTemperature) {
  const DrawnEffect cross_axis = draw_effect(spec_of("cross_axis", {}, 1e-5), 1, 0.5);
  const DrawnEffect lag = draw_effect(spec_of("sensor_lag", {}, 1e6), 1, 0.5);
  HiddenEffects effects;
  effects.add(cross_axis, 1e-5, {});
  effects.add(lag, 1e6, {});
  effects.advance_to(at_rest(0.0, 25.0));
  effects.advance_to(at_rest(1.0, 65.0));  // the elements have hardly noticed
  EXPECT_NEAR(effects.element_c(), 25.0, 1e-3);
  for (const Sensor sensor : calib::kSensors) EXPECT_NEAR(effects.sensed(sensor, 0.0, 0.0), 0.0, 1e-7);
}

TEST(HiddenEffects, VaryBetweenMountingsWithinTheStatedSpread) {
  const ActiveEffect steady(draw_effect(spec_of("warmup_transient", 1.0, {}), 1, 0.5), 1.0, {});
  const ActiveEffect varied(draw_effect(spec_of("warmup_transient", 1.0, {}), 1, 0.5), 1.0, {{}, {}, 0.3});
  double sum = 0.0;
  double squares = 0.0;
  for (int mounting = 0; mounting < 1000; ++mounting) {
    EXPECT_EQ(steady.strength(mounting), 1.0);
    sum += varied.strength(mounting);
    squares += std::pow(varied.strength(mounting) - 1.0, 2.0);
  }
  EXPECT_NEAR(sum / 1000.0, 1.0, 0.04);                 // 4 standard errors
  EXPECT_NEAR(std::sqrt(squares / 1000.0), 0.3, 0.03);  // 4 standard errors; clipping at 3 takes off 1 %
}

}  // namespace
}  // namespace soak::hal::sim
