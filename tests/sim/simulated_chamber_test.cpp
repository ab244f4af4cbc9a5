// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/simulated_chamber.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/sim/lab/device_time.h"
#include "tests/sim/registers.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

// Watlow F4T, data map 1.
constexpr int kAlarmHigh = 1334;
constexpr int kAlarmState = 1356;
constexpr int kMode = 2730;
constexpr int kSetPointLow = 2774;
constexpr int kSetPointHigh = 2776;
constexpr int kSetPoint = 2782;
constexpr int kRampAction = 2794;
constexpr int kRampScale = 2796;
constexpr int kRampRate = 2798;
constexpr int kPower = 2808;
constexpr int kWorkingSetPoint = 2810;
constexpr int kActualMode = 2814;
constexpr int kProcessValue = 2820;
constexpr int kLimitError = 11250;
constexpr int kLimitStatus = 11264;
constexpr int kLimitState = 11288;

constexpr int kAuto = 10;
constexpr int kNone = 61;
constexpr int kOff = 62;

class SimulatedChamberByItsRegisters : public testing::Test {
 protected:
  [[nodiscard]] double value(int address) { return test::value_at(chamber_->registers(), address); }
  [[nodiscard]] int number(int address) { return test::number_at(chamber_->registers(), address); }
  ModbusAnswer set(int address, double value) {
    return test::write_value(chamber_->registers(), address, static_cast<float>(value));
  }
  ModbusAnswer choose(int address, int code) {
    return test::write_number(chamber_->registers(), address, static_cast<std::uint16_t>(code));
  }
  void wait(double duration_s) {
    for (double t_s = 0.0; t_s < duration_s - kStep_s / 2.0; t_s += kStep_s) chamber_->step(kStep_s);
  }

  LabMagnitudes magnitudes_ = test::shipped_config().lab;
  std::unique_ptr<SimulatedChamber> chamber_ = std::make_unique<SimulatedChamber>(magnitudes_, 1);
};

TEST_F(SimulatedChamberByItsRegisters, DoesNothingUnlessAsked) {
  EXPECT_EQ(number(kMode), kOff);
  ASSERT_EQ(set(kSetPoint, 70.0), ModbusAnswer::done);
  wait(3600.0);
  EXPECT_EQ(value(kPower), 0.0);
  EXPECT_EQ(chamber_->plant().air_c(), magnitudes_.plant.room_c);
}

TEST_F(SimulatedChamberByItsRegisters, GoesToTheSetPointThatIsWritten) {
  set(kSetPoint, 60.0);
  choose(kMode, kAuto);
  EXPECT_EQ(number(kActualMode), kAuto);
  wait(60.0);
  EXPECT_EQ(value(kPower), 100.0);
  EXPECT_EQ(value(kWorkingSetPoint), 60.0);
  wait(3600.0);
  EXPECT_NEAR(value(kProcessValue), 60.0, 0.3);
}

TEST_F(SimulatedChamberByItsRegisters, ShowsNoPowerAsSoonAsControlIsOff) {
  set(kSetPoint, 60.0);
  choose(kMode, kAuto);
  wait(60.0);
  ASSERT_EQ(value(kPower), 100.0);
  choose(kMode, kOff);
  EXPECT_EQ(number(kMode), kOff);
  EXPECT_EQ(number(kActualMode), kOff);
  EXPECT_EQ(value(kPower), 0.0);
  EXPECT_EQ(value(kSetPoint), 60.0) << "the set point is kept";
  const double warm_c = chamber_->plant().air_c();
  wait(600.0);
  EXPECT_LT(chamber_->plant().air_c(), warm_c);
}

// 2000 readings: the standard deviation is known to 1.6 %.
TEST_F(SimulatedChamberByItsRegisters, ReadsTheAirWithTheNoiseOfItsSensor) {
  std::vector<double> errors_k;
  for (int i = 0; i < 2000; ++i) {
    wait(kStep_s);
    errors_k.push_back(value(kProcessValue) - chamber_->plant().air_c());
  }
  EXPECT_NEAR(test::rms_of(errors_k), 0.03, 0.06 * 0.03);
  EXPECT_NEAR(test::mean_of(errors_k), 0.0, 4.0 * 0.03 / std::sqrt(2000.0));
}

TEST_F(SimulatedChamberByItsRegisters, ReadsTheSameTwiceAtOneMoment) {
  wait(10.0);
  const double first_c = value(kProcessValue);
  EXPECT_EQ(value(kProcessValue), first_c);
  wait(kStep_s);
  EXPECT_NE(value(kProcessValue), first_c);
}

TEST_F(SimulatedChamberByItsRegisters, RefusesSetPointsBeyondItsLimits) {
  EXPECT_EQ(set(kSetPoint, 180.5), ModbusAnswer::illegal_value);
  EXPECT_EQ(set(kSetPoint, -70.5), ModbusAnswer::illegal_value);
  ASSERT_EQ(set(kSetPointHigh, 85.0), ModbusAnswer::done);
  EXPECT_EQ(set(kSetPoint, 85.5), ModbusAnswer::illegal_value);
  EXPECT_EQ(set(kSetPoint, 85.0), ModbusAnswer::done);
  EXPECT_EQ(set(kSetPointLow, 90.0), ModbusAnswer::illegal_value) << "above the upper limit";
  EXPECT_EQ(set(kSetPointHigh, 251.0), ModbusAnswer::illegal_value) << "beyond the sensor's range";
}

TEST_F(SimulatedChamberByItsRegisters, KnowsTheCodesOfItsModesOnly) {
  EXPECT_EQ(choose(kMode, 54), ModbusAnswer::illegal_value);
  EXPECT_EQ(choose(kMode, 0), ModbusAnswer::illegal_value);
  EXPECT_EQ(choose(kActualMode, kAuto), ModbusAnswer::illegal_address);
  EXPECT_EQ(set(kProcessValue, 20.0), ModbusAnswer::illegal_address);
  EXPECT_EQ(set(kPower, 50.0), ModbusAnswer::illegal_address);
}

TEST_F(SimulatedChamberByItsRegisters, RampsInKelvinPerMinuteOrPerHour) {
  for (const auto& [scale, minutes] : {std::pair(57, 1.0), std::pair(39, 60.0)}) {
    chamber_ = std::make_unique<SimulatedChamber>(magnitudes_, 1);
    set(kSetPoint, 23.0);
    choose(kMode, kAuto);
    choose(kRampAction, 85);
    choose(kRampScale, scale);
    set(kRampRate, 2.0);
    set(kSetPoint, 60.0);
    wait(300.0);
    EXPECT_NEAR(value(kWorkingSetPoint), 23.0 + 10.0 / minutes, 1e-4) << scale;
  }
}

TEST_F(SimulatedChamberByItsRegisters, LatchesTheAlarmWhenItsSetPointIsPutBelowTheAir) {
  choose(kMode, kAuto);
  wait(10.0);
  EXPECT_EQ(number(kAlarmState), kNone);
  ASSERT_EQ(set(kAlarmHigh, 10.0), ModbusAnswer::done);
  wait(kStep_s);
  EXPECT_NE(number(kAlarmState), kNone);
  EXPECT_EQ(number(kActualMode), kAuto) << "the alarm tells; it switches nothing";
  set(kAlarmHigh, 90.0);
  wait(60.0);
  EXPECT_NE(number(kAlarmState), kNone) << "latched";
  choose(kMode, kOff);
  wait(kStep_s);
  EXPECT_EQ(number(kAlarmState), kNone);
}

TEST_F(SimulatedChamberByItsRegisters, HasFiveMoreAlarmsThatAreNotSetUp) {
  for (int alarm = 2; alarm <= 6; ++alarm) EXPECT_EQ(number(kAlarmState + 100 * (alarm - 1)), kNone) << alarm;
  EXPECT_EQ(number(kAlarmState + 600), -1);
}

TEST_F(SimulatedChamberByItsRegisters, CutsTheHeaterWhenTheLimitProtectorTrips) {
  magnitudes_.controller.limit_high_c = 50.0;
  chamber_ = std::make_unique<SimulatedChamber>(magnitudes_, 1);
  EXPECT_EQ(number(kLimitState), kNone);
  set(kSetPoint, 120.0);
  choose(kMode, kAuto);
  wait(1200.0);
  EXPECT_NE(number(kLimitState), kNone);
  EXPECT_EQ(number(kLimitError), 28);
  EXPECT_EQ(number(kLimitStatus), 32);
  EXPECT_EQ(value(kPower), 0.0);
  EXPECT_EQ(number(kActualMode), kAuto);
  // What the hot heating elements and the sensor's lag still allow.
  EXPECT_LT(chamber_->plant().air_c(), 60.0);
}

TEST_F(SimulatedChamberByItsRegisters, IdentifiesItself) {
  std::string part;
  for (int address = 16; address <= 30; ++address) part += static_cast<char>(number(address));
  EXPECT_EQ(part.substr(0, 3), "F4T");
  EXPECT_EQ(number(90), 138);
  EXPECT_EQ(number(6730), 15);
}

TEST_F(SimulatedChamberByItsRegisters, KeepsItsEventOutputs) {
  for (const int address : {16594, 16600, 16822, 16828}) {
    EXPECT_EQ(number(address), kOff);
    EXPECT_EQ(choose(address, 63), ModbusAnswer::done);
    EXPECT_EQ(number(address), 63);
    EXPECT_EQ(choose(address, 1), ModbusAnswer::illegal_value);
  }
}

}  // namespace
}  // namespace soak::hal::sim
