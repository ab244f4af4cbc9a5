// SPDX-License-Identifier: Apache-2.0
// Every shipped map of a chamber against a peer that shares nothing with the driver, set up from the makers' documents
// and not from the maps: pymodbus or espec_peer.py, over TCP (as through a gateway) and over a pseudo-terminal.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <ranges>
#include <string>
#include <vector>

#include "hal/devices/chamber.h"
#include "hal/links/addresses.h"
#include "modbus_peer.h"
#include "text_peer.h"

namespace soak::hal {
namespace {

/// A controller as its documents describe it: control off, air at −40.5 °C, set point 25 °C, limits −60 and 150 °C.
/// A place is a register or a name of espec_peer.py; "place=content" puts something there, as at the front panel.
struct Model {
  const char* map;
  std::vector<std::string> registers;  ///< of pymodbus; none: the controller speaks text
  std::string mode;                    ///< place that says whether control is on
  std::string mode_on;                 ///< its content then
  std::string set_point;               ///< place of the set point, of a float its high word
  std::string at_minus_55;             ///< its content where the set point is −55.5 °C
  std::string at_30;                   ///< and where it is 30 °C, as it is put there
  std::string alarm;                   ///< puts the controller in alarm
  std::string alarm_name;
  std::string probe;                        ///< place that a probe looks at
  std::string wrong_content;                ///< of another controller or setting there
  int writes_to_start;                      ///< from the state above
  std::vector<std::string> impossible_air;  ///< each puts a temperature there that no chamber has
};

class Peer {
 public:
  virtual ~Peer() = default;
  [[nodiscard]] virtual int port() const = 0;
  [[nodiscard]] virtual std::string peek(const std::string& place) = 0;
  virtual void poke(const std::string& place, const std::string& content) = 0;
  /// Commands that wrote.
  [[nodiscard]] virtual int writes() = 0;
};

class ModbusPeer final : public Peer {
 public:
  explicit ModbusPeer(std::unique_ptr<test::PymodbusServer> server) : server_(std::move(server)) {}
  int port() const override { return server_->port(); }
  std::string peek(const std::string& place) override {
    return test::mbpoll_read(server_->look_port(), std::stoi(place), "4");
  }
  void poke(const std::string& place, const std::string& content) override {
    ASSERT_TRUE(test::mbpoll_write(server_->look_port(), std::stoi(place), "4", content)) << place;
  }
  int writes() override { return server_->writes(); }

 private:
  std::unique_ptr<test::PymodbusServer> server_;
};

class EspecPeer final : public Peer {
 public:
  explicit EspecPeer(int port) : peer_("espec_peer.py", port) { poke("air", "-40.5"); }
  int port() const override { return peer_.port(); }
  std::string peek(const std::string& place) override { return peer_.tell("get " + place); }
  void poke(const std::string& place, const std::string& content) override {
    ASSERT_EQ(peer_.tell(fmt::format("set {} {}", place, content)), "OK");
  }
  int writes() override {
    for (const auto command : std::views::split(peer_.tell("log"), '|')) {
      if (!command.empty() && command.back() != '?') ++writes_;
    }
    return writes_;
  }

 private:
  test::TextPeer peer_;
  int writes_ = 0;
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

// High words of IEEE 754 numbers: C25E is −55.5, 41F0 is 30, C317 −151, 7FC0 not a number.
constexpr const char* kMinus55 = "49758 (-15778)";
constexpr const char* k30 = "16880";

const Model kF4t = {
    .map = "watlow-f4t",
    .registers = f4t_cold(),
    .mode = "2814",
    .mode_on = "10",
    .set_point = "2783",
    .at_minus_55 = kMinus55,
    .at_30 = k30,
    .alarm = "1356=37",
    .alarm_name = "alarm 1",
    .probe = "14080",
    .wrong_content = "30",
    .writes_to_start = 1,
    // −151, 401, not a number, and 2e-41, which is 23.25 with its words exchanged.
    .impossible_air = {"2821=49943", "2820=32768 2821=17352", "2821=32704", "2820=16826 2821=0"},
};

const Model kF4 = {
    .map = "watlow-f4",
    .registers = {"i16:100:-405", "u16:101:0", "i16:300:250", "i16:602:-600", "i16:603:1500", "u16:606:1", "u16:608:0",
                  "u16:901:1", "u16:1217:0", "u16:2000:0"},
    .mode = "2000",
    .mode_on = "1",
    .set_point = "300",
    .at_minus_55 = "64981 (-555)",
    .at_30 = "300",
    .alarm = "101=1",
    .alarm_name = "input 1 error",
    .probe = "901",
    .wrong_content = "0",
    .writes_to_start = 2,
    .impossible_air = {"100=5000"},
};

Model eurotherm_model(const char* map) {
  return {
      .map = map,
      .registers = eurotherm(),
      .mode = "199",
      .mode_on = "0",
      .set_point = "32772",
      .at_minus_55 = kMinus55,
      .at_30 = k30,
      .alarm = "75=544",  // 0x220: sensor break, and bit 9, program complete, which is no alarm
      .alarm_name = "sensor break",
      .probe = "199",
      .wrong_content = "2",
      .writes_to_start = 1,
      .impossible_air = {"32770=32704"},
  };
}

const Model kP300 = {
    .map = "espec-p300",
    .registers = {},
    .mode = "mode",
    .mode_on = "CONSTANT",
    .set_point = "sp",
    .at_minus_55 = "-55.5",
    .at_30 = "30.0",
    .alarm = "alarm=3 17",
    .alarm_name = "alarm",
    .probe = "mode",
    .wrong_content = "ON",
    .writes_to_start = 1,
    .impossible_air = {"air=999.9", "air=-151", "air=nan"},
};

/// Wire and model.
using Case = std::tuple<std::string, Model>;

/// A chamber of the model behind the wire, with its driver.
class ShippedChamber : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    std::tie(wire_, model_) = GetParam();
    if (std::string(model_.map) == "watlow-f4t" && wire_ == "tcp") model_.probe = "6730";
    if (!test::have_program("mbpoll")) GTEST_SKIP() << "skipped: mbpoll is not installed";
    SOAK_NEED_SOCAT();
    start_peer(0);
    if (!peer_) GTEST_SKIP() << "skipped: python3-pymodbus is not installed";
    DeviceMap map = test::repository_map(fmt::format("chambers/{}.toml", model_.map), peer_->port());
    if (wire_ == "serial") {
      line_ = std::make_unique<test::SerialLine>(peer_->port());
      map.link.address = SerialAddress{.device = line_->path(), .baud = 19200};
    }
    map.link.response_timeout_s = 1.0;  // a busy machine lets the peer wait
    auto chamber = make_chamber(map);
    ASSERT_TRUE(chamber) << chamber.error().message;
    chamber_ = *std::move(chamber);
  }

  void start_peer(int port) {
    peer_.reset();
    if (model_.registers.empty()) {
      peer_ = std::make_unique<EspecPeer>(port);
    } else if (auto server = test::PymodbusServer::start(wire_ == "serial" ? "rtu" : "tcp", model_.registers, port)) {
      peer_ = std::make_unique<ModbusPeer>(std::move(server));
    }
  }

  /// "place=content", several of them between blanks; a content of several words stands alone.
  void poke(const std::string& what) const {
    if (std::ranges::count(what, '=') == 1)
      return peer_->poke(what.substr(0, what.find('=')), what.substr(what.find('=') + 1));
    for (const auto part : std::views::split(what, ' ')) poke(std::string(part.begin(), part.end()));
  }

  std::string wire_;
  Model model_;
  std::unique_ptr<Peer> peer_;
  std::unique_ptr<test::SerialLine> line_;
  std::unique_ptr<Chamber> chamber_;
};

using test::text_of;

TEST_P(ShippedChamber, ReadsWhatTheControllerHolds) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, -40.5);
  EXPECT_EQ(reading->set_point_c, 25.0);
  EXPECT_FALSE(reading->running);
  EXPECT_TRUE(reading->alarms.empty());
  EXPECT_EQ(chamber_->min_set_point_c(), -60.0);
  EXPECT_EQ(chamber_->max_set_point_c(), 150.0);
  EXPECT_EQ(peer_->writes(), 0);
}

TEST_P(ShippedChamber, WritesASetPointOnceAndReadsItBack) {
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  EXPECT_EQ(peer_->peek(model_.set_point), model_.at_minus_55);
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  EXPECT_EQ(peer_->writes(), 1) << "an unchanged set point is not written: EEPROM";
  EXPECT_EQ(chamber_->read()->set_point_c, -55.5);
}

TEST_P(ShippedChamber, RefusesASetPointBeyondTheControllersLimitsOrThatIsNoNumber) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  for (const double wanted_c : {-60.5, 150.5, std::nan("")}) {
    const auto refused = chamber_->set_temperature(wanted_c);
    ASSERT_FALSE(refused) << wanted_c;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_EQ(peer_->writes(), 0);
}

TEST_P(ShippedChamber, SwitchesControlOnAndOff) {
  ASSERT_EQ(text_of(chamber_->start()), "");
  EXPECT_EQ(peer_->peek(model_.mode), model_.mode_on);
  EXPECT_TRUE(chamber_->read()->running);
  EXPECT_EQ(peer_->writes(), model_.writes_to_start);
  ASSERT_EQ(text_of(chamber_->stop()), "");
  EXPECT_NE(peer_->peek(model_.mode), model_.mode_on);
  EXPECT_FALSE(chamber_->read()->running);
}

TEST_P(ShippedChamber, ReportsAnAlarmThatSwitchesOff) {
  poke(model_.alarm);
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->alarms, (std::vector<ChamberAlarm>{{model_.alarm_name, true}}));
}

TEST_P(ShippedChamber, RefusesAnotherControllerOrSettingAndGivesNoValueOfIt) {
  peer_->poke(model_.probe, model_.wrong_content);
  const auto status = chamber_->connect();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  const std::string place =
      model_.registers.empty() ? "(field 1 of 'MODE?')" : fmt::format("(register {})", model_.probe);
  EXPECT_NE(status.error().message.find(place), std::string::npos) << status.error().message;
  EXPECT_NE(status.error().message.find(model_.wrong_content), std::string::npos) << status.error().message;
  EXPECT_FALSE(chamber_->read());
}

std::string name_of_case(const ::testing::TestParamInfo<Case>& info) {
  std::string name = fmt::format("{}_{}", std::get<1>(info.param).map, std::get<0>(info.param));
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Models, ShippedChamber,
                         ::testing::Combine(::testing::Values("tcp", "serial"),
                                            ::testing::Values(kF4t, kF4, eurotherm_model("eurotherm-2400"),
                                                              eurotherm_model("eurotherm-2200"), kP300)),
                         name_of_case);

/// What does not depend on the map: one model of each protocol.
class ChamberDriver : public ShippedChamber {};

TEST_P(ChamberDriver, WritesAgainWhatSomebodyChangedAtTheController) {
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  peer_->poke(model_.set_point, model_.at_30);
  EXPECT_EQ(chamber_->read()->set_point_c, 30.0);
  ASSERT_EQ(text_of(chamber_->set_temperature(-55.5)), "");
  EXPECT_EQ(peer_->peek(model_.set_point), model_.at_minus_55);
}

TEST_P(ChamberDriver, RefusesATemperatureThatNoChamberHas) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  for (const std::string& air : model_.impossible_air) {
    poke(air);
    const auto reading = chamber_->read();
    ASSERT_FALSE(reading) << air;
    EXPECT_EQ(reading.error().kind, base::ErrorKind::device);
    EXPECT_NE(reading.error().message.find("air_c ("), std::string::npos) << reading.error().message;
  }
}

TEST_P(ChamberDriver, SaysThatNobodyListensAndWhere) {
  const int port = peer_->port();
  peer_.reset();
  const auto status = chamber_->connect();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_NE(status.error().where.find(fmt::format(" at 127.0.0.1:{}", port)), std::string::npos)
      << status.error().where;
}

TEST_P(ChamberDriver, ComesBackAfterThePeerHasRestarted) {
  const auto read = [&] { return chamber_->read(); };
  const auto check = [](const ChamberReading& reading) {
    ASSERT_EQ(reading.air_c, -40.5);
    ASSERT_EQ(reading.set_point_c, 25.0);
    ASSERT_FALSE(reading.running);
  };
  test::expect_recovery<ChamberReading>(read, check);
  const int port = peer_->port();
  peer_.reset();
  const auto lost = chamber_->read();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, base::ErrorKind::device);
  start_peer(port);
  test::expect_recovery<ChamberReading>(read, check);
}

INSTANTIATE_TEST_SUITE_P(Protocols, ChamberDriver, ::testing::Values(Case{"tcp", kF4t}, Case{"tcp", kP300}),
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
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_NE(status.error().message.find("set_point_c (registers 32772 to 32773)"), std::string::npos)
      << status.error().message;
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
  EXPECT_EQ(server->writes(), 2)
      << "control is off already: that command and the end of a profile are sent all the same";
}

}  // namespace
}  // namespace soak::hal
