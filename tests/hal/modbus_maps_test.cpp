// SPDX-License-Identifier: Apache-2.0
// Every shipped map of a Modbus chamber against pymodbus, whose registers are set from the makers' documents and not
// from the maps: over TCP (as through a gateway) and over RTU on a pseudo-terminal.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/devices/chamber.h"
#include "hal/links/addresses.h"
#include "modbus_peer.h"

namespace soak::hal {
namespace {

/// A controller as its documents describe it: control off, air at −40.5 °C, set point 25 °C, limits −60 and 150 °C.
struct Model {
  const char* map;
  std::vector<std::string> registers;
  int mode;                   ///< register that says whether control is on
  std::string mode_on;        ///< its content then
  int set_point;              ///< register of the set point, of a float its high word
  std::string at_minus_55;    ///< its content where the set point is −55.5 °C, as mbpoll shows it
  int alarm;                  ///< a register that tells of an alarm
  std::string alarm_content;  ///< when it does
  std::string alarm_name;
  int probe;                  ///< register of a probe
  std::string wrong_content;  ///< of another controller or setting there
  int writes_to_start;        ///< from the state above
};

std::vector<std::string> f4t_cold() {
  auto registers = test::f4t_registers();
  registers.insert(registers.end(), {"f32lo:2820:-40.5", "f32lo:2774:-60", "u16:14080:15"});
  return registers;
}

std::vector<std::string> eurotherm() {
  // 0x8000 + 2 n: process value 1, set point 2, output 3, 4 is not configured, working set point 5, limits 111 and 112.
  return {"f32hi:32770:-40.5", "f32hi:32772:25",  "f32hi:32774:0", "f32hi:32776:1e30", "f32hi:32778:25",
          "f32hi:32990:150",   "f32hi:32992:-60", "u16:199:1",     "u16:75:0x0200",    "u16:273:0"};
}

Model eurotherm_model(const char* map) {
  // −55.5 is C25E 0000 in IEEE 754. 544 = 0x220: sensor break, and bit 9, program complete, which is no alarm.
  return {map, eurotherm(), 199, "0", 32772, "49758 (-15778)", 75, "544", "sensor break", 199, "2", 1};
}

const Model kF4t = {"watlow-f4t", f4t_cold(), 2814,      "10",  2783, "49758 (-15778)",
                    1356,         "37",       "alarm 1", 14080, "30", 1};
const Model kF4 = {"watlow-f4",
                   {"i16:100:-405", "u16:101:0", "i16:300:250", "i16:602:-600", "i16:603:1500", "u16:606:1",
                    "u16:608:0", "u16:901:1", "u16:1217:0", "u16:2000:0"},
                   2000,
                   "1",
                   300,
                   "64981 (-555)",
                   101,
                   "1",
                   "input 1 error",
                   901,
                   "0",
                   2};

/// Framing and model.
using Case = std::tuple<std::string, Model>;

class ShippedMap : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    auto [framing, model] = GetParam();
    if (std::string(model.map) == "watlow-f4t" && framing == "tcp") model.probe = 6730;
    model_ = model;
    server_ = test::PymodbusServer::start(framing, model.registers);
    if (!server_) GTEST_SKIP() << "skipped: python3-pymodbus is not installed";
    if (!test::have_program("mbpoll")) GTEST_SKIP() << "skipped: mbpoll is not installed";
    SOAK_NEED_SOCAT();
    DeviceMap map = test::repository_map(fmt::format("chambers/{}.toml", model.map), server_->port());
    if (framing == "rtu") {
      line_ = std::make_unique<test::SerialLine>(server_->port());
      map.link.address = SerialAddress{.device = line_->path(), .baud = 19200};
    }
    map.link.response_timeout_s = 1.0;
    auto chamber = make_chamber(map);
    ASSERT_TRUE(chamber) << chamber.error().message;
    chamber_ = *std::move(chamber);
  }
  [[nodiscard]] std::string peek(int address) const { return test::mbpoll_read(server_->look_port(), address, "4"); }
  void poke(int address, const std::string& content) const {
    ASSERT_TRUE(test::mbpoll_write(server_->look_port(), address, "4", content));
  }

  Model model_;
  std::unique_ptr<test::PymodbusServer> server_;
  std::unique_ptr<test::SerialLine> line_;
  std::unique_ptr<Chamber> chamber_;
};

std::string text_of(const base::Status& status) { return status ? "" : status.error().message; }

TEST_P(ShippedMap, ReadsWhatTheControllerHolds) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, -40.5);
  EXPECT_EQ(reading->set_point_c, 25.0);
  EXPECT_FALSE(reading->running);
  EXPECT_TRUE(reading->alarms.empty());
  EXPECT_EQ(chamber_->min_set_point_c(), -60.0);
  EXPECT_EQ(chamber_->max_set_point_c(), 150.0);
  EXPECT_EQ(server_->writes(), 0);
}

TEST_P(ShippedMap, WritesASetPointOnceAndReadsItBack) {
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  EXPECT_EQ(peek(model_.set_point), model_.at_minus_55);
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  EXPECT_EQ(server_->writes(), 1) << "an unchanged set point is not written: EEPROM";
  EXPECT_EQ(chamber_->read()->set_point_c, -55.5);
}

TEST_P(ShippedMap, RefusesASetPointBeyondTheControllersLimits) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  for (const double wanted_c : {-60.5, 150.5}) {
    const auto refused = chamber_->set_temperature(wanted_c);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_EQ(server_->writes(), 0);
}

TEST_P(ShippedMap, SwitchesControlOnAndOff) {
  ASSERT_EQ(text_of(chamber_->start()), "");
  EXPECT_EQ(peek(model_.mode), model_.mode_on);
  EXPECT_TRUE(chamber_->read()->running);
  EXPECT_EQ(server_->writes(), model_.writes_to_start);
  ASSERT_EQ(text_of(chamber_->stop()), "");
  EXPECT_NE(peek(model_.mode), model_.mode_on);
  EXPECT_FALSE(chamber_->read()->running);
}

TEST_P(ShippedMap, ReportsAnAlarmThatSwitchesOff) {
  poke(model_.alarm, model_.alarm_content);
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->alarms, (std::vector<ChamberAlarm>{{model_.alarm_name, true}}));
}

TEST_P(ShippedMap, RefusesAnotherControllerOrSetting) {
  poke(model_.probe, model_.wrong_content);
  const auto status = chamber_->connect();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find(fmt::format("(register {}) is ", model_.probe)), std::string::npos)
      << status.error().message;
}

std::string name_of_case(const ::testing::TestParamInfo<Case>& info) {
  std::string name = fmt::format("{}_{}", std::get<1>(info.param).map, std::get<0>(info.param));
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

INSTANTIATE_TEST_SUITE_P(Models, ShippedMap,
                         ::testing::Combine(::testing::Values("tcp", "rtu"),
                                            ::testing::Values(kF4t, kF4, eurotherm_model("eurotherm-2400"),
                                                              eurotherm_model("eurotherm-2200"))),
                         name_of_case);

// The Eurotherm handbook: a write to an address that the instrument lacks succeeds and does nothing.
TEST(EurothermMap, FindsAWriteThatIsAcceptedAndIgnored) {
  auto registers = eurotherm();
  registers.insert(registers.end(), {"stuck:32772:0", "stuck:32773:0"});
  SOAK_START_PYMODBUS(server, "tcp", registers);
  const auto chamber = make_chamber(test::repository_map("chambers/eurotherm-2400.toml", server->port()));
  ASSERT_TRUE(chamber);
  const auto status = (*chamber)->set_temperature(60.0);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "set_point_c (registers 32772 to 32773) holds 25 where 60 was written");
}

// The handbook: other contents of the instrument mode than 0 and 1 may destroy the calibration.
TEST(EurothermMap, CanWriteNothingButNormalAndStandbyToTheInstrumentMode) {
  for (const char* file : {"eurotherm-2400", "eurotherm-2200"}) {
    const DeviceMap map = test::repository_map(fmt::format("chambers/{}.toml", file), 1);
    const Quantity& mode = map.quantities.at("control_mode");
    EXPECT_EQ(mode.modbus.address, 199);
    EXPECT_EQ(mode.min, 0.0);
    EXPECT_EQ(mode.max, 1.0);
    EXPECT_EQ(mode.codes, (std::map<std::string, int>{{"auto", 0}, {"off", 1}}));
    for (const auto& [name, quantity] : map.quantities) {
      EXPECT_TRUE(name == "control_mode" || quantity.modbus.address != 199) << name;
    }
  }
}

TEST(EurothermMap, KeepsTheLimitsOfThe2200) {
  const DeviceMap map = test::repository_map("chambers/eurotherm-2200.toml", 1);
  EXPECT_LE(map.link.max_block, 32);
  EXPECT_GE(map.link.gap_s.value_or(0.0), 0.1);
  EXPECT_TRUE(map.write_policy.only_on_change);
}

TEST(F4Map, EndsAProfileEachTimeThoughItsRegisterHoldsTheCommandAlready) {
  auto registers = kF4.registers;
  registers.emplace_back("u16:1217:1");
  SOAK_START_PYMODBUS(server, "tcp", registers);
  const auto chamber = make_chamber(test::repository_map("chambers/watlow-f4.toml", server->port()));
  ASSERT_TRUE(chamber);
  ASSERT_TRUE((*chamber)->stop());
  EXPECT_EQ(server->writes(), 1) << "control is off already, the command is sent all the same";
}

}  // namespace
}  // namespace soak::hal
