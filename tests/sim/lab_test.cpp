// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/lab.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/sim/measurements.h"
#include "tests/sim/registers.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using base::Bytes;

constexpr int kPositionRequest = 0;
constexpr int kPositionActual = 1;
constexpr int kFixtureStatus = 2;

/// A laboratory of which every byte that units send is kept.
struct RecordedLab {
  explicit RecordedLab(const CampaignConfig& config) : lab(config), sent(lab.unit_count()) {}

  /// `stride`: the largest part of the way to the next event that is taken at once.
  void run_until(double time_s, Tick stride = 1'000'000) {
    const Tick end = ticks_of(time_s);
    while (lab.now() < end) {
      lab.advance_to(std::min({lab.next_due(), lab.now() + stride, end}));
      for (std::size_t i = 0; i < sent.size(); ++i) {
        const Bytes bytes = lab.device(i).take_output();
        sent[i].insert(sent[i].end(), bytes.begin(), bytes.end());
      }
    }
  }

  void switch_output(int output, bool on) {
    ASSERT_EQ(test::write_number(lab.relay().registers(), output - 1, on ? 1 : 0), ModbusAnswer::done);
  }
  void turn_to(std::uint16_t position) {
    ASSERT_EQ(test::write_number(lab.fixture().registers(), kPositionRequest, position), ModbusAnswer::done);
  }
  [[nodiscard]] int fixture(int address) { return test::number_at(lab.fixture().registers(), address); }

  SimulatedLab lab;
  std::vector<Bytes> sent;
};

/// A short campaign: power, heat, turns, power off and on.
std::vector<Bytes> session(std::uint64_t seed, Tick stride) {
  CampaignConfig config = test::shipped_config();
  config.seed = seed;
  RecordedLab lab(config);
  lab.run_until(3.0, stride);
  lab.switch_output(1, true);
  lab.switch_output(3, true);
  lab.run_until(10.0025, stride);
  test::write_value(lab.lab.chamber().registers(), 2782, 40.0F);
  test::write_number(lab.lab.chamber().registers(), 2730, 10);
  lab.turn_to(1);
  lab.run_until(60.0, stride);
  lab.switch_output(1, false);
  lab.run_until(70.0, stride);
  lab.switch_output(1, true);
  lab.turn_to(6);
  lab.run_until(120.0, stride);
  return lab.sent;
}

TEST(Lab, SendsTheSameBytesForTheSameCommandsAtTheSameDeviceTimes) {
  const std::vector<Bytes> sent = session(5, 1'000'000);
  ASSERT_GT(sent[0].size(), 100'000U);
  EXPECT_TRUE(sent[1].empty()) << "never powered";
  EXPECT_EQ(session(5, 7), sent) << "however time is divided";
  EXPECT_NE(session(6, 7)[0], sent[0]);
}

// What a unit reads does not depend on the moment at which it is powered, as long as its temperature does not either.
TEST(Lab, GivesAUnitTheSameNoiseWheneverItIsPowered) {
  std::vector<std::vector<test::Measurement>> runs;
  for (const double start_s : {1.0, 7.2625}) {
    RecordedLab lab(test::shipped_config());
    lab.run_until(start_s);
    lab.switch_output(1, true);
    lab.run_until(start_s + 30.0);
    runs.push_back(test::measurements_in(lab.sent[0]));
  }
  ASSERT_GT(runs[0].size(), 2800U);
  std::size_t same = 0;
  const std::size_t count = std::min(runs[0].size(), runs[1].size());
  for (std::size_t i = 0; i < count; ++i) {
    if (runs[0][i].gyro_rps == runs[1][i].gyro_rps) ++same;
  }
  // Self-heating follows the steps of the chamber: rarely a value falls to the other side of a step of the converter.
  EXPECT_GT(static_cast<double>(same), 0.98 * static_cast<double>(count));
}

TEST(Lab, FeedsAUnitFromItsOutputOnly) {
  RecordedLab lab(test::shipped_config());
  lab.switch_output(2, true);
  lab.run_until(5.0);
  EXPECT_TRUE(lab.sent[0].empty());
  EXPECT_FALSE(lab.sent[1].empty());
  lab.switch_output(2, false);
  const std::size_t size = lab.sent[1].size();
  lab.run_until(60.0);
  EXPECT_EQ(lab.sent[1].size(), size);
}

// The unit takes the chamber's temperature, less by time constants than half an hour, whether it is powered or not.
TEST(Lab, WarmsUnitsWithoutPower) {
  RecordedLab lab(test::shipped_config());
  test::write_value(lab.lab.chamber().registers(), 2782, 60.0F);
  test::write_number(lab.lab.chamber().registers(), 2730, 10);
  lab.run_until(5400.0);
  lab.switch_output(1, true);
  lab.run_until(5402.0);
  const auto measurements = test::measurements_in(lab.sent[0]);
  const auto first =
      std::find_if(measurements.begin(), measurements.end(), [](const auto& m) { return m.temp_c.has_value(); });
  ASSERT_NE(first, measurements.end());
  EXPECT_NEAR(*first->temp_c, 60.0, 0.3);
}

// Turns at constant rate: 5 s for each quarter. The gyros' integral is the angle; 1000 samples of noise add
// 0.0375 °/s/√Hz · √10 s = 0.12°, bias up to 0.8 °/s is taken from the time before.
TEST(Lab, TurnsTheUnitsWithTheFixture) {
  RecordedLab lab(test::shipped_config());
  lab.switch_output(1, true);  // mounted +X+Y+Z
  lab.run_until(22.0);
  const std::size_t before = test::measurements_in(lab.sent[0]).size();
  lab.turn_to(6);
  EXPECT_EQ(lab.fixture(kPositionActual), 0);
  EXPECT_EQ(lab.fixture(kFixtureStatus), 1);
  lab.run_until(31.9);
  EXPECT_EQ(lab.fixture(kFixtureStatus), 1);
  lab.run_until(32.1);
  EXPECT_EQ(lab.fixture(kPositionActual), 6);
  EXPECT_EQ(lab.fixture(kFixtureStatus), 0);
  lab.run_until(40.0);

  const auto measurements = test::measurements_in(lab.sent[0]);
  std::array<double, 3> angle_deg{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double resting_rps = 0.0;
    for (std::size_t i = before - 1000; i < before; ++i) resting_rps += measurements[i].gyro_rps->at(axis) / 1000.0;
    for (std::size_t i = before; i < before + 1100; ++i) {
      angle_deg[axis] += (measurements[i].gyro_rps->at(axis) - resting_rps) * 0.01 * 180.0 / std::numbers::pi;
    }
  }
  const double turned_deg = std::hypot(angle_deg[0], angle_deg[1], angle_deg[2]);
  EXPECT_NEAR(turned_deg, 180.0, 2.5) << "misalignment and g-sensitivity included";
  EXPECT_NEAR(measurements.at(before - 1).accel_mps2->at(2), 9.8, 0.5);
  EXPECT_NEAR(measurements.back().accel_mps2->at(2), -9.8, 0.5);
}

TEST(Lab, CarriesOutTheLastOfSeveralRequestsToTurn) {
  RecordedLab lab(test::shipped_config());
  lab.turn_to(1);
  lab.run_until(1.0);
  lab.turn_to(3);
  lab.turn_to(4);
  EXPECT_EQ(lab.fixture(kPositionRequest), 4);
  lab.run_until(60.0);
  EXPECT_EQ(lab.fixture(kPositionActual), 4);
}

TEST(Lab, HasFixtureAndRelayThatIdentifyThemselves) {
  RecordedLab lab(test::shipped_config());
  EXPECT_EQ(lab.fixture(32), 0x5046);
  EXPECT_EQ(lab.fixture(kPositionActual), 5) << "+Z";
  EXPECT_EQ(test::number_at(lab.lab.relay().registers(), 32), 0x5052);
  EXPECT_EQ(test::write_number(lab.lab.fixture().registers(), 0, 7), ModbusAnswer::illegal_value);
  EXPECT_EQ(test::write_number(lab.lab.relay().registers(), 0, 2), ModbusAnswer::illegal_value);
  EXPECT_EQ(test::write_number(lab.lab.relay().registers(), 16, 1), ModbusAnswer::illegal_address);
  for (const auto& [asked, state] : {std::pair(15, 31), std::pair(64, 128), std::pair(111, 175)}) {
    EXPECT_EQ(test::write_number(lab.lab.relay().registers(), asked, 1), ModbusAnswer::done);
    EXPECT_EQ(test::number_at(lab.lab.relay().registers(), state), 1);
  }
  EXPECT_EQ(test::write_number(lab.lab.relay().registers(), 112, 1), ModbusAnswer::illegal_address);
}

// All slots point their accelerometers' sum where the fixture points up.
TEST(Lab, MountsUnitsInTheirSlotsDirections) {
  CampaignConfig config = test::shipped_config();
  config.units = 4;
  RecordedLab lab(config);
  for (int output = 1; output <= 4; ++output) lab.switch_output(output, true);
  lab.turn_to(1);  // the fixture's +X up
  lab.run_until(20.0);
  // "+X+Y+Z", "+Y-X+Z", "+Z+X+Y", "-X-Y+Z": the unit's axis along the fixture's +X, and its sign.
  const std::vector<std::pair<std::size_t, double>> expected = {{0, 1.0}, {1, -1.0}, {1, 1.0}, {0, -1.0}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto measurements = test::measurements_in(lab.sent[i]);
    const auto [axis, sign] = expected[i];
    EXPECT_NEAR(measurements.back().accel_mps2->at(axis), sign * 9.80665, 0.6) << i;
  }
}

}  // namespace
}  // namespace soak::hal::sim
