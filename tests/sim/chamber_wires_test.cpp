// SPDX-License-Identifier: Apache-2.0
// Other controllers in the place of the simulated chamber's F4T, by what their makers and users publish of them.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "hal/sim/lab/device_time.h"
#include "hal/sim/wires/detail/chamber_wire.h"
#include "tests/sim/registers.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

/// The float32 at `address`, high word first.
double high_first_at(const RegisterTable& registers, int address) {
  std::array<std::uint16_t, 2> words{};
  if (registers.read(address, words) != ModbusAnswer::done) return -1e9;
  const std::uint32_t raw = static_cast<std::uint32_t>(words[0]) << 16 | words[1];
  float value = 0.0F;
  std::memcpy(&value, &raw, sizeof value);
  return static_cast<double>(value);
}

class OtherControllers : public testing::Test {
 protected:
  void wait(double duration_s) {
    for (double t_s = 0.0; t_s < duration_s; t_s += kStep_s) chamber_->step(kStep_s);
  }

  LabMagnitudes magnitudes_ = test::shipped_config().lab;
  std::unique_ptr<SimulatedChamber> chamber_ = std::make_unique<SimulatedChamber>(magnitudes_, 1);
  RegisterTable eurotherm_ = eurotherm_registers(*chamber_);
};

TEST_F(OtherControllers, EurothermTakesAFloatHighWordFirstAndShowsItAsAnInteger) {
  // −40 is C220 0000 (HA026230: 32768 + 2 · 2 = 32772).
  ASSERT_EQ(eurotherm_.write(32772, std::array<std::uint16_t, 2>{0xC220, 0x0000}), ModbusAnswer::done);
  EXPECT_EQ(high_first_at(eurotherm_, 32772), -40.0);
  EXPECT_EQ(test::number_at(eurotherm_, 2), 65536 - 400);
  EXPECT_EQ(test::value_at(chamber_->registers(), 2782), -40.0) << "the F4T's register of the set point";
}

TEST_F(OtherControllers, EurothermWorksTheChamberByItsInstrumentMode) {
  ASSERT_EQ(eurotherm_.write(32772, std::array<std::uint16_t, 2>{0x4270, 0x0000}), ModbusAnswer::done);  // 60
  wait(60.0);
  EXPECT_EQ(high_first_at(eurotherm_, 32774), 0.0) << "standby";
  ASSERT_EQ(test::write_number(eurotherm_, 199, 0), ModbusAnswer::done);
  wait(3600.0);
  EXPECT_NEAR(high_first_at(eurotherm_, 32770), 60.0, 0.3);
  EXPECT_NEAR(test::number_at(eurotherm_, 1), 600, 4);
  EXPECT_EQ(high_first_at(eurotherm_, 32778), 60.0);
  EXPECT_EQ(test::write_number(eurotherm_, 199, 2), ModbusAnswer::illegal_value);
}

TEST_F(OtherControllers, EurothermTakesWritesToWhatItDoesNotHaveAndDoesNothing) {
  EXPECT_EQ(test::write_number(eurotherm_, 4000, 7), ModbusAnswer::done);
  EXPECT_NE(test::number_at(eurotherm_, 4000), 7);
  EXPECT_EQ(test::write_number(eurotherm_, 1, 7), ModbusAnswer::illegal_address) << "the process value is only read";
}

TEST_F(OtherControllers, BothTellTheAlarm) {
  EXPECT_EQ(test::number_at(eurotherm_, 75), 0);
  EXPECT_EQ(espec_answer(*chamber_, "ALARM?"), "0");
  ASSERT_EQ(test::write_value(chamber_->registers(), 1334, 20.0F), ModbusAnswer::done);  // below the air
  wait(1.0);
  EXPECT_EQ(test::number_at(eurotherm_, 75), 1);
  EXPECT_EQ(espec_answer(*chamber_, "ALARM?").substr(0, 2), "1,");
}

TEST_F(OtherControllers, EspecTakesWhatItsUsersSend) {
  EXPECT_EQ(espec_answer(*chamber_, "TEMP, S60.0"), "OK:TEMP, S60.0");
  EXPECT_EQ(espec_answer(*chamber_, "MODE,CONSTANT"), "OK:MODE,CONSTANT");
  wait(3600.0);
  const std::string answer = espec_answer(*chamber_, "TEMP?");
  EXPECT_NEAR(std::stod(answer), 60.0, 0.3);
  EXPECT_EQ(answer.substr(answer.find(',')), ",60.0,180.0,-70.0");
  EXPECT_EQ(espec_answer(*chamber_, "temp?"), "NA:CMD ERR");
  EXPECT_EQ(espec_answer(*chamber_, "TEMP, S1e3"), "NA:DATA OUT OF RANGE");
}

TEST(RtuCrc, IsThatOfDocumentedFrames) {
  // HA026230 and Watlow's guide; low byte first on the wire.
  EXPECT_EQ(rtu_crc(std::array<std::uint8_t, 6>{0x02, 0x03, 0x00, 0x01, 0x00, 0x02}), 0xF895);
  EXPECT_EQ(rtu_crc(std::array<std::uint8_t, 3>{0x01, 0x86, 0x02}), 0xA1C3);
}

}  // namespace
}  // namespace soak::hal::sim
