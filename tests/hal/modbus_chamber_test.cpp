// SPDX-License-Identifier: Apache-2.0
// The chamber driver against pymodbus, a Modbus implementation that is not libmodbus; mbpoll looks at and changes the
// server's registers beside it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hal/devices/chamber.h"
#include "hal/devices/unit_power.h"
#include "hal/links/addresses.h"
#include "modbus_peer.h"
#include "tests/errors.h"
#include "text_peer.h"

namespace soak::hal {
namespace {

std::unique_ptr<Chamber> f4t(int port) {
  auto chamber = make_chamber(test::repository_map("chambers/watlow-f4t.toml", port));
  if (!chamber) throw std::runtime_error(chamber.error().message);
  return *std::move(chamber);
}

using test::text_of;

class ModbusChamberTest : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ = test::PymodbusServer::start("tcp", test::f4t_registers());
    if (!server_) GTEST_SKIP() << "skipped: python3-pymodbus is not installed";
    if (!test::have_program("mbpoll")) GTEST_SKIP() << "skipped: mbpoll is not installed";
    chamber_ = f4t(server_->port());
  }
  bool poke(int address, const std::string& type, const std::string& value) const {
    return test::mbpoll_write(server_->port(), address, type, value);
  }
  std::string peek(int address, const std::string& type) const {
    return test::mbpoll_read(server_->port(), address, type);
  }

  std::unique_ptr<test::PymodbusServer> server_;
  std::unique_ptr<Chamber> chamber_;
};

TEST_F(ModbusChamberTest, ReadsWhatTheServerHolds) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, 23.25);
  EXPECT_EQ(reading->set_point_c, 25.0);
  EXPECT_EQ(reading->working_set_point_c, 24.5);
  EXPECT_EQ(reading->output_percent, -12.5);
  EXPECT_FALSE(reading->running);
  EXPECT_TRUE(reading->alarms.empty());
}

TEST_F(ModbusChamberTest, TakesTheNarrowerOfMapAndControllerLimits) {
  EXPECT_EQ(chamber_->max_set_point_c(), 180.0);
  ASSERT_EQ(text_of(chamber_->connect()), "");
  EXPECT_EQ(chamber_->min_set_point_c(), -68.0);
  EXPECT_EQ(chamber_->max_set_point_c(), 150.0);
  const auto status = chamber_->set_temperature(151.0);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(server_->writes(), 0);
}

TEST_F(ModbusChamberTest, SetsARampInKelvinPerMinuteAndSwitchesItOff) {
  ASSERT_TRUE(chamber_->can_ramp());
  ASSERT_EQ(text_of(chamber_->set_ramp_rate(2.5)), "");
  EXPECT_EQ(peek(2798, "4:float"), "2.5");
  EXPECT_EQ(peek(2796, "4"), "57");
  EXPECT_EQ(peek(2794, "4"), "85");
  ASSERT_EQ(text_of(chamber_->set_ramp_rate(std::nullopt)), "");
  EXPECT_EQ(peek(2794, "4"), "62");
}

TEST_F(ModbusChamberTest, IsToldToGoOffAgainWhereItsRegisterSaysOffAndItGoesOn) {
  ASSERT_TRUE(poke(2814, "4", "10"));  // what it does; what it was told stands in 2730
  ASSERT_EQ(peek(2730, "4"), "62");
  ASSERT_TRUE(chamber_->read()->running);
  ASSERT_EQ(text_of(chamber_->stop()), "");
  EXPECT_FALSE(chamber_->read()->running);
}

TEST_F(ModbusChamberTest, ReportsAlarmsByTheirCodes) {
  ASSERT_TRUE(poke(1456, "4", "37"));   // high
  ASSERT_TRUE(poke(1356, "4", "88"));   // startup: inactive
  ASSERT_TRUE(poke(11250, "4", "28"));  // sensor error of the limit card
  ASSERT_TRUE(poke(11288, "4", "1667"));
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  const std::vector<ChamberAlarm> expected = {{"alarm 2", true}, {"limit sensor error", true}, {"limit tripped", true}};
  EXPECT_EQ(reading->alarms, expected);
}

TEST_F(ModbusChamberTest, NamesQuantityRegisterAndPlaceOfAnError) {
  DeviceMap map = test::repository_map("chambers/watlow-f4t.toml", server_->port());
  map.quantities["air_c"].modbus.address = 5000;  // not served
  const auto chamber = make_chamber(map);
  ASSERT_TRUE(chamber);
  const auto reading = (*chamber)->read();
  ASSERT_FALSE(reading);
  EXPECT_TRUE(names(reading.error(), {"air_c (registers 5000 to 5001)"}));
  EXPECT_EQ(reading.error().where, fmt::format("Watlow F4T at 127.0.0.1:{}", server_->port()));
}

// As of a Watlow F4: integers, whose decimals stand in a register; and of a Eurotherm: floats high word first.
const char* const kIntegerMap = R"(
name = "integers"
kind = "chamber"
[link]
tcp = "127.0.0.1:502"
response_timeout_s = 1
[quantity.air_c]
address = 100
type = "i16"
decimals_register = 606
[quantity.set_point_c]
address = 300
type = "i16"
scale = 0.01
write_function = 6
[quantity.output_percent]
address = 32774
type = "f32"
word_order = "high_first"
[quantity.working_set_point_c]
address = 7
type = "i16"
read_function = 4
scale = 0.1
[quantity.control_mode]
address = 199
type = "u16"
write_function = 16
codes = { auto = 0, off = 1 }
[[alarm]]
name = "sensor break"
addresses = [74]
mask = 0x20
outputs_off = true
)";

TEST(ModbusChamber, ReadsIntegersWithDecimalsAndFloatsHighWordFirst) {
  SOAK_START_PYMODBUS(
      server, "tcp",
      {"i16:100:-405", "u16:606:1", "i16:300:-4025", "f32hi:32774:1.001", "in:7:251", "u16:199:1", "u16:74:0x21"});
  DeviceMap map = test::parsed_map(kIntegerMap);
  map.link.address = TcpAddress{"127.0.0.1", server->port()};
  const auto chamber = make_chamber(map);
  ASSERT_TRUE(chamber) << chamber.error().message;
  const auto reading = (*chamber)->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, -40.5);
  EXPECT_EQ(reading->set_point_c, -40.25);
  EXPECT_EQ(reading->working_set_point_c, 25.1);
  EXPECT_EQ(reading->output_percent, 1.001F);
  EXPECT_EQ(reading->alarms, (std::vector<ChamberAlarm>{{"sensor break", true}}));
  ASSERT_EQ(text_of((*chamber)->set_temperature(-55.5)), "");
  EXPECT_EQ(test::mbpoll_read(server->port(), 300, "4"), "59986 (-5550)");
  ASSERT_EQ(text_of((*chamber)->start()), "");
  EXPECT_TRUE((*chamber)->read()->running);
}

TEST(ModbusChamber, SwitchesUnitsByOutputsOfItsOwnAndTellsTheHumidity) {
  SOAK_START_PYMODBUS(server, "tcp",
                      {"i16:100:250", "u16:606:1", "i16:300:2500", "f32hi:32774:0", "in:7:251", "u16:199:1", "u16:74:0",
                       "u16:20:83", "u16:16596:62"});
  DeviceMap map = test::parsed_map(std::string(kIntegerMap) + R"(
[quantity.air_rh_percent]
address = 20
type = "u16"
scale = 0.1
[quantity.unit_power_2]
address = 16596
type = "u16"
write_function = 6
codes = { off = 62, on = 63 }
)");
  map.link.address = TcpAddress{"127.0.0.1", server->port()};
  const auto chamber = make_chamber(map);
  ASSERT_TRUE(chamber) << chamber.error().message;
  EXPECT_DOUBLE_EQ((*chamber)->read()->air_rh_percent.value(), 8.3);
  UnitPower* power = (*chamber)->unit_power();
  ASSERT_NE(power, nullptr);
  EXPECT_FALSE(power->read({2})->at(2).on);
  ASSERT_EQ(text_of(power->set(2, true)), "");
  EXPECT_EQ(test::mbpoll_read(server->port(), 16596, "4"), "63");
  EXPECT_TRUE(power->read({2})->at(2).on);
  EXPECT_FALSE(power->measures(2));
  EXPECT_FALSE(power->check(1, {})) << "the map has no such output";
  ASSERT_EQ(text_of(power->set(2, false)), "");
  EXPECT_EQ(test::mbpoll_read(server->port(), 16596, "4"), "62");
}

TEST(ModbusChamber, WithoutSuchOutputsSwitchesNothing) {
  const auto chamber = make_chamber(test::parsed_map(kIntegerMap));
  ASSERT_TRUE(chamber);
  EXPECT_EQ((*chamber)->unit_power(), nullptr);
}

TEST(ModbusChamber, FollowsTheDecimalsRegisterWhenItChanges) {
  SOAK_START_PYMODBUS(server, "tcp",
                      {"i16:100:-405", "u16:606:1", "i16:300:0", "f32hi:32774:0", "in:7:0", "u16:199:1", "u16:74:0"});
  DeviceMap map = test::parsed_map(kIntegerMap);
  map.link.address = TcpAddress{"127.0.0.1", server->port()};
  const auto chamber = make_chamber(map);
  ASSERT_TRUE(chamber);
  EXPECT_EQ((*chamber)->read()->air_c, -40.5);
  ASSERT_TRUE(test::mbpoll_write(server->port(), 606, "4", "2"));
  EXPECT_EQ((*chamber)->read()->air_c, -4.05);
}

TEST(ModbusChamber, RefusesAMapThatLacksWhatAChamberNeeds) {
  for (const char* quantity : {"air_c", "set_point_c", "control_mode"}) {
    DeviceMap map = test::parsed_map(kIntegerMap);
    map.quantities.erase(quantity);
    const auto chamber = make_chamber(map);
    ASSERT_FALSE(chamber) << quantity;
    EXPECT_EQ(chamber.error().kind, base::ErrorKind::bad_input);
    EXPECT_TRUE(names(chamber.error(), {quantity}));
  }
  DeviceMap map = test::parsed_map(kIntegerMap);
  map.kind = "power";
  EXPECT_FALSE(make_chamber(map));
}

}  // namespace
}  // namespace soak::hal
