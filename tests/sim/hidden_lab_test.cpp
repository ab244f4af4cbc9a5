// SPDX-License-Identifier: Apache-2.0
// Effects hidden in the laboratory of soaksim.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/hash.h"
#include "hal/sim/lab/inertial_unit.h"
#include "hal/sim/lab/lab.h"
#include "hal/sim/programs/programs.h"
#include "tests/sim/design_support.h"

namespace soak::hal::sim {
namespace {

/// A unit in a chamber whose air is driven with a constant output, and the same unit without hidden effects.
struct TwoUnits {
  explicit TwoUnits(const HiddenSpec& spec) : plain_config(test::shipped_config()), config(plain_config) {
    config.hidden = {spec};
    hidden.emplace(config, 1);
    plain.emplace(plain_config, 1);
    plant.emplace(config.lab.plant);
    attitude.up = {0.0, 0.0, 1.0};
  }

  void power() {
    hidden->start();
    plain->start();
  }

  void run(double duration_s, double output) {
    for (int i = 0; i < static_cast<int>(std::lround(duration_s / kStep_s)); ++i) {
      plant->step(kStep_s, output);
      hidden->step(*plant, attitude);
      plain->step(*plant, attitude);
    }
  }

  /// What the effects make of the mean of 400 samples, in rad/s; noise is the same with and without.
  double gyro_difference(std::size_t axis) {
    double sum = 0.0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      sum += static_cast<double>(hidden->rate_of_turn(attitude, i, 100.0).value[axis]) -
             static_cast<double>(plain->rate_of_turn(attitude, i, 100.0).value[axis]);
    }
    return sum / 400.0;
  }

  CampaignConfig plain_config;
  CampaignConfig config;
  std::optional<InertialUnit> hidden;
  std::optional<InertialUnit> plain;
  std::optional<ChamberPlant> plant;
  Attitude attitude;
};

// The mean of 400 words of 0.0137 deg/s whose noise is 0.4 deg/s: 0.0137/√12/20 is 0.0002 deg/s of rounding.
constexpr double kTolerance = 0.001 * base::kRadPerDeg;

TEST(HiddenLab, AddsWarmUpSincePowerOn) {
  TwoUnits units({"warmup_transient", {}, 2.0, 1, {calib::Sensor::gyro_x}});
  units.run(600.0, 0.0);
  units.power();
  units.run(0.1, 0.0);
  EXPECT_NEAR(units.gyro_difference(0), 2.0 * base::kRadPerDeg, 2.0 * kTolerance);
  EXPECT_NEAR(units.gyro_difference(1), 0.0, 1e-9);
  units.run(40000.0, 0.0);
  EXPECT_NEAR(units.gyro_difference(0), 0.0, 2.0 * kTolerance);
  units.power();
  units.run(0.1, 0.0);
  EXPECT_NEAR(units.gyro_difference(0), 2.0 * base::kRadPerDeg, 2.0 * kTolerance) << "each power-on draws its own";
}

TEST(HiddenLab, ShiftsWhileTheCompressorCools) {
  TwoUnits units({"vibration_rectification", {}, 1.0, 1, {calib::Sensor::gyro_y}});
  units.power();
  units.run(300.0, 1.0);
  EXPECT_NEAR(units.gyro_difference(1), 0.0, kTolerance) << "heating";
  double most = 0.0;
  double least = 1.0;
  for (int i = 0; i < 240; ++i) {
    units.run(1.0, -0.5);
    const double shift = units.gyro_difference(1) / base::kRadPerDeg;
    if (i < 120) continue;
    most = std::max(most, shift);
    least = std::min(least, shift);
  }
  EXPECT_GT(most, 0.9) << "half of each cycle";
  EXPECT_LT(least, 0.1);
}

TEST(HiddenLab, LagsWhileItsTemperatureChangesAndNotAtRest) {
  TwoUnits units({"sensor_lag", {}, 300.0, 1, {}});
  units.power();
  units.run(20000.0, 0.0);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(units.gyro_difference(axis), 0.0, 3.0 * kTolerance);
  const double before_c = units.hidden->temp_c();
  units.run(900.0, 1.0);
  EXPECT_GT(units.hidden->temp_c(), before_c + 10.0);
  EXPECT_EQ(units.hidden->temp_c(), units.plain->temp_c()) << "the thermometer knows nothing of it";
  double largest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(units.gyro_difference(axis)));
  EXPECT_GT(largest, 10.0 * kTolerance);
}

TEST(HiddenLab, FeelsForceInTheAxesOfTheUnit) {
  TwoUnits units({"g_sensitivity", {}, 1.0, 2, {}});
  const DrawnEffect drawn = draw_effect(units.config.hidden.front(), 1, 0.5);
  const ActiveEffect active(drawn, 1.0, {});
  units.power();
  units.run(1.0, 0.0);
  std::map<std::string, double> shape;
  for (const ShapeParameter& parameter : active.shape()) shape[parameter.name] = parameter.value;
  // Slot 1 is mounted straight: up is the unit's own z.
  const std::array<std::string, 3> elements = {"m_xz", "m_yz", "m_zz"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(units.gyro_difference(axis), shape[elements[axis]] * base::kRadPerDeg, 2.0 * kTolerance);
  }
}

// The bytes that three units sent before there were hidden effects.
TEST(HiddenLab, LeavesALaboratoryWithoutEffectsAsItWas) {
  CampaignConfig config = test::shipped_config();
  config.seed = 5;
  SimulatedLab lab(config);
  base::Sha256 hash;
  const auto run_until = [&](double time_s) {
    const Tick end = ticks_of(time_s);
    while (lab.now() < end) {
      lab.advance_to(std::min(lab.next_due(), end));
      for (std::size_t i = 0; i < lab.unit_count(); ++i) hash.update(lab.device(i).take_output());
    }
  };
  run_until(3.0);
  lab.device(0).switch_power(true, lab.now());
  lab.device(2).switch_power(true, lab.now());
  run_until(200.0);
  lab.device(0).switch_power(false, lab.now());
  run_until(210.0);
  lab.device(0).switch_power(true, lab.now());
  run_until(400.0);
  EXPECT_EQ(base::to_hex(hash.finish()), "3010053ff481884697c7561b7fb95e1914db485a5f60c80b17418ba027ab6dd2");
}

TEST(HiddenLab, IsToldByTheTruthOfTheLaboratory) {
  const test::TemporaryFolder folder;
  const auto config = folder.path() / "lab.toml";
  std::ofstream(config) << test::content_of(test::kShippedConfig)
                        << test::hidden("warmup_transient", "amplitude = 0.5\nsensors = [\"gyro_x\"]");
  const ProgramOutcome outcome = run_soaksim_truth({"--config", config.string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.errors;
  const auto truth = nlohmann::json::parse(outcome.output);
  for (const auto& unit : truth["units"]) {
    ASSERT_EQ(unit["hidden"].size(), 1U);
    EXPECT_EQ(unit["hidden"][0]["name"], "warmup_transient");
    EXPECT_EQ(unit["hidden"][0]["sensors"]["gyro_x"]["amplitude"], 0.5);
    EXPECT_TRUE(unit["hidden"][0]["shape"].contains("slow_s"));
  }
  EXPECT_FALSE(nlohmann::json::parse(run_soaksim_truth({}).output)["units"][0].contains("hidden"));
}

TEST(HiddenLab, RefusesAMagnitudeSinceThereIsNoPlan) {
  const test::TemporaryFolder folder;
  const auto config = folder.path() / "lab.toml";
  std::ofstream(config) << test::content_of(test::kShippedConfig) << test::hidden("sensor_lag", "magnitude = 1.0");
  const ProgramOutcome outcome =
      run_soaksim({"--out", folder.path().string(), "--config", config.string()}, -1, [](const std::string&) {});
  EXPECT_EQ(outcome.exit_status, 2);
  EXPECT_NE(outcome.errors.find("'amplitude'"), std::string::npos) << outcome.errors;
}

TEST(HiddenLab, RefusesACandidateSinceThereIsNoPlan) {
  const test::TemporaryFolder folder;
  const auto config = folder.path() / "lab.toml";
  std::ofstream(config) << test::content_of(test::kShippedConfig)
                        << "[[candidate]]\neffect = \"sensor_lag\"\namplitude = 300\nseed = 1\n";
  const ProgramOutcome outcome =
      run_soaksim({"--out", folder.path().string(), "--config", config.string()}, -1, [](const std::string&) {});
  EXPECT_EQ(outcome.exit_status, 2);
  EXPECT_NE(outcome.errors.find("[[candidate]]"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace soak::hal::sim
