// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/chamber_plant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/inertial_unit.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

constexpr double kNever_s = 1e12;

void run(ChamberPlant& plant, double output, double duration_s) {
  const auto steps = static_cast<int>(std::lround(duration_s / kStep_s));
  for (int i = 0; i < steps; ++i) plant.step(kStep_s, output);
}

PlantMagnitudes shipped_plant() { return test::shipped_config().lab.plant; }

// The slow eigenvalue of the two equations in chamber_plant.h, without power.
TEST(ChamberPlant, DecaysToTheRoomAtTheRateOfItsSlowEigenvalue) {
  const PlantMagnitudes m = shipped_plant();
  ChamberPlant plant(m);
  run(plant, 1.0, 1200.0);
  run(plant, 0.0, 1200.0);  // sixteen time constants of the fast one
  const double start_k = plant.air_c() - m.room_c;
  run(plant, 0.0, 3600.0);

  const double trace =
      -(m.load_to_air / m.load_settling_time_s + (1.0 + m.load_to_air) / m.leak_time_s) - 1.0 / m.load_settling_time_s;
  const double determinant = (1.0 + m.load_to_air) / (m.leak_time_s * m.load_settling_time_s);
  const double slow = (trace + std::sqrt(trace * trace - 4.0 * determinant)) / 2.0;
  ASSERT_GT(start_k, 30.0);
  EXPECT_NEAR(std::log((plant.air_c() - m.room_c) / start_k), slow * 3600.0, 1e-4);
}

// Without leakage heat goes into air and load alone: both warm at the stated rate, the load behind by τload times it.
TEST(ChamberPlant, WarmsAirAndLoadAtTheStatedRate) {
  PlantMagnitudes m = shipped_plant();
  m.leak_time_s = kNever_s;
  ChamberPlant plant(m);
  run(plant, 1.0, 2400.0);
  const double air_c = plant.air_c();
  const double load_c = plant.load_c();
  run(plant, 1.0, 600.0);
  EXPECT_NEAR((plant.air_c() - air_c) / 600.0, m.heating_kps, 1e-6 * m.heating_kps);
  EXPECT_NEAR((plant.load_c() - load_c) / 600.0, m.heating_kps, 1e-6 * m.heating_kps);
  EXPECT_NEAR(plant.air_c() - plant.load_c(), m.load_settling_time_s * m.heating_kps, 1e-3);
}

TEST(ChamberPlant, CoolsAtTheStatedRateOverWholeCyclesOfTheCompressor) {
  PlantMagnitudes m = shipped_plant();
  m.leak_time_s = kNever_s;
  ChamberPlant plant(m);
  run(plant, -1.0, 40.0 * m.compressor_period_s);
  const double load_c = plant.load_c();
  run(plant, -1.0, 10.0 * m.compressor_period_s);
  EXPECT_NEAR((plant.load_c() - load_c) / (10.0 * m.compressor_period_s), -m.cooling_kps, 1e-3 * m.cooling_kps);
}

// Alone with the air, without load and room, the refrigeration shows itself as it is.
TEST(ChamberPlant, CoolsMoreInTheFirstHalfOfACycleOfTheCompressorThanInTheSecond) {
  PlantMagnitudes m = shipped_plant();
  m.leak_time_s = kNever_s;
  m.load_to_air = 0.0;
  ChamberPlant plant(m);
  run(plant, -1.0, 20.0 * m.compressor_period_s);
  const double half_s = m.compressor_period_s / 2.0;
  const double start_c = plant.air_c();
  run(plant, -1.0, half_s);
  const double middle_c = plant.air_c();
  run(plant, -1.0, half_s);
  // One step of 300 may fall into the other half.
  EXPECT_NEAR((start_c - middle_c) / half_s, 1.2 * m.cooling_kps, 0.002 * m.cooling_kps);
  EXPECT_NEAR((middle_c - plant.air_c()) / half_s, 0.8 * m.cooling_kps, 0.002 * m.cooling_kps);
}

TEST(ChamberPlant, ComesToRestWhereLeakageEqualsTheHeating) {
  const PlantMagnitudes m = shipped_plant();
  ChamberPlant plant(m);
  run(plant, 0.1, 12.0 * m.leak_time_s);
  const double rise_k = 0.1 * m.heating_kps * m.leak_time_s;
  EXPECT_NEAR(plant.air_c() - m.room_c, rise_k, 1e-4 * rise_k);
  EXPECT_NEAR(plant.load_c() - m.room_c, rise_k, 1e-4 * rise_k);
}

// In a chamber at rest, with 1/τ' = 1/τ + 1/τload: T − Troom = self-heating · τ'/τ · (1 − e^(−t/τ')).
TEST(UnitHeat, WarmsItselfWhilePoweredAndCoolsWhileNot) {
  const ChamberPlant at_rest(shipped_plant());
  const double room_c = at_rest.air_c();
  UnitHeat unit(room_c, 200.0, 4000.0, 1.0);
  const double time_s = 1.0 / (1.0 / 200.0 + 1.0 / 4000.0);
  const double final_k = time_s / 200.0;
  for (int i = 0; i < 3000; ++i) unit.step(kStep_s, at_rest, true);
  const double warm_k = unit.temp_c() - room_c;
  EXPECT_NEAR(warm_k, final_k * (1.0 - std::exp(-300.0 / time_s)), 2e-4);
  for (int i = 0; i < 3000; ++i) unit.step(kStep_s, at_rest, false);
  EXPECT_NEAR(unit.temp_c() - room_c, warm_k * std::exp(-300.0 / time_s), 2e-4);
}

}  // namespace
}  // namespace soak::hal::sim
