// SPDX-License-Identifier: Apache-2.0
// The two-axis fixture of the laboratory, as its registers and the units' own sensors tell of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <utility>
#include <vector>

#include "hal/sim/lab/lab.h"
#include "tests/sim/measurements.h"
#include "tests/sim/registers.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

constexpr int kOuterRequest = 0;
constexpr int kInnerRequest = 2;
constexpr int kRateRequest = 4;
constexpr int kCommand = 6;
constexpr int kOuterAngle = 10;
constexpr int kInnerAngle = 12;
constexpr int kRate = 14;
constexpr int kStatus = 16;

CampaignConfig one_unit() {
  CampaignConfig config = test::shipped_config();
  config.units = 1;
  return config;
}

/// A laboratory with one unit that is mounted straight, from its power-on.
struct TwoAxisLab {
  explicit TwoAxisLab(const CampaignConfig& config = one_unit()) : lab(config, {.fixture = FixtureKind::two_axis}) {
    EXPECT_EQ(test::write_number(lab.relay().registers(), 0, 1), ModbusAnswer::done);
    run(5.0);
  }

  void run(double seconds) {
    const Tick end = lab.now() + ticks_of(seconds);
    while (lab.now() < end) lab.advance_to(std::min(lab.next_due(), end));
    const base::Bytes bytes = lab.device(0).take_output();
    sent.insert(sent.end(), bytes.begin(), bytes.end());
  }

  [[nodiscard]] RegisterTable& registers() { return lab.fixture().registers(); }
  /// Floats high word first.
  void ask(int address, float value) {
    std::uint32_t raw = 0;
    std::memcpy(&raw, &value, sizeof raw);
    const std::array words{static_cast<std::uint16_t>(raw >> 16), static_cast<std::uint16_t>(raw & 0xFFFF)};
    EXPECT_EQ(registers().write(address, words), value > 1000.0F ? ModbusAnswer::illegal_value : ModbusAnswer::done);
  }
  [[nodiscard]] float told(int address) {
    std::array<std::uint16_t, 2> words{};
    EXPECT_EQ(registers().read(address, words), ModbusAnswer::done);
    const std::uint32_t raw = static_cast<std::uint32_t>(words[0]) << 16 | words[1];
    float value = 0.0F;
    std::memcpy(&value, &raw, sizeof value);
    return value;
  }
  void command(std::uint16_t number) {
    EXPECT_EQ(test::write_number(registers(), kCommand, number), ModbusAnswer::done);
  }
  void go_to(float outer_deg, float inner_deg) {
    ask(kOuterRequest, outer_deg);
    ask(kInnerRequest, inner_deg);
    command(1);
  }
  [[nodiscard]] bool stands() { return test::number_at(registers(), kStatus) == 0; }

  SimulatedLab lab;
  base::Bytes sent;
};

/// Mean of the accelerometers over the last second.
std::array<double, 3> force(const TwoAxisLab& lab) {
  const auto all = test::measurements_in(lab.sent);
  std::array<double, 3> mean{};
  for (std::size_t i = all.size() - 100; i < all.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) mean[axis] += all[i].accel_mps2->at(axis) / 100.0;
  }
  return mean;
}

// Tilted by 90 degrees about its x axis the table's y points up; turned by 90 degrees about its own axis, its x.
TEST(TwoAxisLab, BringsTheDirectionUpThatTheAnglesSay) {
  TwoAxisLab lab;
  const std::vector<std::pair<std::array<float, 2>, std::array<double, 3>>> stops = {
      {{0, 0}, {0, 0, 1}},
      {{90, 90}, {1, 0, 0}},
      {{90, -90}, {-1, 0, 0}},
      {{90, 0}, {0, 1, 0}},
      {{90, 180}, {0, -1, 0}},
      {{180, 45}, {0, 0, -1}},
      {{45, 0}, {0, std::sqrt(0.5), std::sqrt(0.5)}}};
  for (const auto& [angles, up] : stops) {
    lab.go_to(angles[0], angles[1]);
    lab.run(30.0);
    lab.sent.clear();
    lab.run(1.5);
    EXPECT_TRUE(lab.stands());
    EXPECT_EQ(lab.told(kOuterAngle), angles[0]);
    EXPECT_NEAR(std::remainder(lab.told(kInnerAngle) - angles[1], 360.0F), 0.0, 1e-4);
    const auto seen = force(lab);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(seen[axis], 9.80665 * up[axis], 0.6) << angles[0] << ", " << angles[1] << " axis " << axis;
    }
  }
}

TEST(TwoAxisLab, TurnsAtFiniteSpeedOnlyOnceItIsTold) {
  TwoAxisLab lab;
  lab.ask(kOuterRequest, 90.0F);
  lab.run(1.0);
  EXPECT_EQ(lab.told(kOuterAngle), 0.0F);
  EXPECT_TRUE(lab.stands());
  lab.command(1);
  lab.run(2.5);  // 5 s for a quarter
  EXPECT_NEAR(lab.told(kOuterAngle), 45.0, 0.1);
  EXPECT_FALSE(lab.stands());
  lab.go_to(0.0F, 0.0F);
  lab.run(1.0);
  EXPECT_NEAR(lab.told(kOuterAngle), 27.0, 0.2) << "a command in mid-way is begun from there";
  lab.run(2.0);
  EXPECT_TRUE(lab.stands());
}

TEST(TwoAxisLab, RefusesAnglesAndRatesBeyondItsLimits) {
  TwoAxisLab lab;
  lab.ask(kOuterRequest, 2000.0F);
  lab.ask(kInnerRequest, 2000.0F);
  lab.ask(kRateRequest, 2000.0F);
  EXPECT_EQ(test::write_number(lab.registers(), kCommand, 3), ModbusAnswer::illegal_value);
  EXPECT_EQ(test::number_at(lab.registers(), 32), 0x5441);
}

// The rotation of the Earth in a body that was turned twice is that of a body that stands with that face up and that
// heading: headings of the axis after the vertical one, worked out by hand, clockwise from the base's.
TEST(TwoAxisLab, CarriesTheRotationOfTheEarthIntoEveryPosition) {
  struct Stop {
    const char* label;
    float outer_deg;
    float inner_deg;
    double heading_deg;
  };
  constexpr std::array<Stop, 6> stops = {{{"+X", 90, 90, 180},
                                          {"-X", 90, -90, 0},
                                          {"+Y", 90, 0, 90},
                                          {"-Y", 90, 180, 90},
                                          {"+Z", 0, 0, 0},
                                          {"-Z", 180, 0, 0}}};
  const EarthFrame base{48.0, 30.0};
  CampaignConfig config = one_unit();
  config.earth = base;
  for (const Stop& stop : stops) {
    TwoAxisLab lab(config);
    lab.go_to(stop.outer_deg, stop.inner_deg);
    lab.run(30.0);
    const Attitude held = lab.lab.fixture().attitude();
    const Attitude expected =
        resting(*calib::position_named(stop.label), EarthFrame{base.latitude_deg, base.azimuth_deg + stop.heading_deg});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(held.up[axis], expected.up[axis], 1e-9) << stop.label;
      EXPECT_NEAR(held.rate_rps[axis], expected.rate_rps[axis], 1e-12) << stop.label;
    }
  }
}

// The gyro about the vertical reads the rate that was asked for: its bias (below 0.8 deg/s) cancels between the senses.
TEST(TwoAxisLab, TurnsTheUnitsAtTheRateThatTheirGyrosRead) {
  TwoAxisLab lab;
  std::array<double, 2> mean_dps{};
  for (const std::size_t sense : {0U, 1U}) {
    lab.ask(kRateRequest, sense == 0 ? 60.0F : -60.0F);
    lab.command(2);
    EXPECT_FALSE(lab.stands());
    lab.run(5.0);
    EXPECT_TRUE(lab.stands());
    EXPECT_EQ(lab.told(kRate), sense == 0 ? 60.0F : -60.0F);
    lab.run(10.0);
    const auto all = test::measurements_in(lab.sent);
    for (std::size_t i = all.size() - 900; i < all.size(); ++i) {
      mean_dps[sense] += all[i].gyro_rps->at(2) * 180.0 / std::numbers::pi / 900.0;
    }
  }
  EXPECT_NEAR(0.5 * (mean_dps[0] - mean_dps[1]), 60.0, 0.1);
  EXPECT_NEAR(force(lab)[2], 9.8, 0.5);
  const float before_deg = lab.told(kInnerAngle);
  lab.ask(kRateRequest, 0.0F);
  lab.command(2);
  lab.run(3.0);
  EXPECT_EQ(lab.told(kRate), 0.0F);
  EXPECT_TRUE(lab.stands());
  // 60 deg/s at 50 deg/s^2: 36 degrees more in its sense.
  EXPECT_NEAR(std::remainder(lab.told(kInnerAngle) - before_deg + 36.0F, 360.0F), 0.0, 0.1);
}

}  // namespace
}  // namespace soak::hal::sim
