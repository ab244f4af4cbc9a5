// SPDX-License-Identifier: Apache-2.0
// The fixture and the relays against pymodbus.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "hal/devices/fixture.h"
#include "hal/devices/unit_power.h"
#include "modbus_peer.h"
#include "tests/errors.h"

namespace soak::hal {
namespace {

std::vector<std::string> positioner_registers() { return {"u16:0:5", "u16:1:5", "u16:2:0", "u16:32:0x5046"}; }

std::vector<std::string> relay_registers(int stuck_contact) {
  std::vector<std::string> specs = {"u16:32:0x5052"};
  for (int i = 0; i < 16; ++i) {
    specs.push_back(fmt::format("u16:{}:0", i));
    specs.push_back(fmt::format("u16:{}:0", i + 16));
    if (i + 1 != stuck_contact) specs.push_back(fmt::format("copy:{}:{}", i, i + 16));
  }
  return specs;
}

TEST(ModbusFixture, TurnsAndTellsWhereItStands) {
  SOAK_START_PYMODBUS(server, "tcp", positioner_registers());
  const auto fixture = make_fixture(test::repository_map("fixtures/modbus-positioner.toml", server->port()));
  ASSERT_TRUE(fixture) << fixture.error().message;
  EXPECT_EQ((*fixture)->positions(), (std::vector<std::string>{"+X", "-X", "+Y", "-Y", "+Z", "-Z"}));
  EXPECT_EQ((*fixture)->read()->position, "+Z");
  ASSERT_TRUE((*fixture)->move_to("-X"));
  EXPECT_EQ(test::mbpoll_read(server->port(), 0, "4"), "2");
  ASSERT_TRUE(test::mbpoll_write(server->port(), 2, "4", "1"));
  EXPECT_TRUE((*fixture)->read()->moving);
  EXPECT_EQ((*fixture)->read()->position, std::nullopt);
  ASSERT_TRUE(test::mbpoll_write(server->port(), 1, "4", "2"));
  ASSERT_TRUE(test::mbpoll_write(server->port(), 2, "4", "0"));
  EXPECT_FALSE((*fixture)->read()->moving);
  EXPECT_EQ((*fixture)->read()->position, "-X");
}

TEST(ModbusFixture, ReportsFaultAndUnknownCodesAsDeviceErrors) {
  SOAK_START_PYMODBUS(server, "tcp", positioner_registers());
  const auto fixture = make_fixture(test::repository_map("fixtures/modbus-positioner.toml", server->port()));
  ASSERT_TRUE(fixture);
  for (const auto& [address, value] : {std::pair{2, "2"}, std::pair{2, "7"}, std::pair{1, "7"}}) {
    ASSERT_TRUE(test::mbpoll_write(server->port(), 2, "4", "0"));
    ASSERT_TRUE(test::mbpoll_write(server->port(), address, "4", value));
    const auto reading = (*fixture)->read();
    ASSERT_FALSE(reading) << address << " " << value;
    EXPECT_EQ(reading.error().kind, base::ErrorKind::device);
  }
  const auto unknown = (*fixture)->move_to("+W");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, base::ErrorKind::bad_input);
}

TEST(ModbusFixture, ACodeThatTheMapDoesNotKnowIsToldWithItsRegisterAndThoseThatItKnows) {
  SOAK_START_PYMODBUS(server, "tcp", positioner_registers());
  const auto fixture = make_fixture(test::repository_map("fixtures/modbus-positioner.toml", server->port()));
  ASSERT_TRUE(fixture);
  ASSERT_TRUE(test::mbpoll_write(server->port(), 1, "4", "9"));
  EXPECT_TRUE(names((*fixture)->read().error(), {"position (register 1)", " 9"}));
  ASSERT_TRUE(test::mbpoll_write(server->port(), 2, "4", "77"));
  EXPECT_TRUE(names((*fixture)->read().error(), {"status (register 2)", "77", "standing = 0", "fault = 2"}));
}

TEST(ModbusFixture, APositionThatIsNoWholeNumberIsRefused) {
  // 1.9 would pass for position 1, and what is no number for anything.
  DeviceMap as_float = test::repository_map("fixtures/modbus-positioner.toml", 1);
  as_float.quantities.at("position").modbus.type = RegisterType::f32;
  DeviceMap scaled = test::repository_map("fixtures/modbus-positioner.toml", 1);
  scaled.quantities.at("position").modbus.scale = 0.1;
  for (const DeviceMap& map : {as_float, scaled}) {
    const auto fixture = make_fixture(map);
    ASSERT_FALSE(fixture);
    EXPECT_EQ(fixture.error().kind, base::ErrorKind::bad_input);
    EXPECT_TRUE(names(fixture.error(), {"[quantity.position]"}));
  }
}

TEST(ModbusFixture, RequestsAPositionAgainAfterItWasTurnedByHand) {
  SOAK_START_PYMODBUS(server, "tcp", positioner_registers());
  const auto fixture = make_fixture(test::repository_map("fixtures/modbus-positioner.toml", server->port()));
  ASSERT_TRUE(fixture);
  ASSERT_TRUE((*fixture)->move_to("+Z"));
  EXPECT_EQ(server->writes(), 1);
}

TEST(ModbusPower, SwitchesOneOutputAndReadsItsContact) {
  SOAK_START_PYMODBUS(server, "tcp", relay_registers(0));
  const auto power = make_unit_power(test::repository_map("power/modbus-relay.toml", server->port()));
  ASSERT_TRUE(power) << power.error().message;
  ASSERT_TRUE((*power)->set(16, true));
  EXPECT_EQ(test::mbpoll_read(server->port(), 15, "4"), "1");
  const auto readings = (*power)->read({15, 16});
  ASSERT_TRUE(readings) << readings.error().message;
  EXPECT_FALSE(readings->at(15).on);
  EXPECT_TRUE(readings->at(16).on);
  EXPECT_EQ(readings->at(16).voltage_v, std::nullopt);
  EXPECT_FALSE((*power)->measures(16));
  ASSERT_TRUE((*power)->set(16, false));
  EXPECT_FALSE((*power)->read({16})->at(16).on);
}

TEST(ModbusPower, FindsAContactThatDoesNotFollow) {
  SOAK_START_PYMODBUS(server, "tcp", relay_registers(3));
  const auto power = make_unit_power(test::repository_map("power/modbus-relay.toml", server->port()));
  ASSERT_TRUE(power);
  const auto status = (*power)->set(3, true);
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"state_3 (register 18)"}));
}

TEST(ModbusPower, RefusesAnOutputThatItDoesNotHave) {
  const auto power = make_unit_power(test::repository_map("power/modbus-relay.toml", 1));
  ASSERT_TRUE(power);
  const auto status = (*power)->set(17, true);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
  EXPECT_TRUE(names((*power)->check(3, {.voltage_v = 12.0}).error(), {"'set_v_3'"}));
}

TEST(ModbusPower, RefusesAPositionerInItsPlace) {
  SOAK_START_PYMODBUS(server, "tcp", positioner_registers());
  const auto power = make_unit_power(test::repository_map("power/modbus-relay.toml", server->port()));
  ASSERT_TRUE(power);
  const auto status = (*power)->connect();
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"identification (register 32)", "20550", "20562"}));
}

}  // namespace
}  // namespace soak::hal
