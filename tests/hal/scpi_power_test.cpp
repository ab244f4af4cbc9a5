// SPDX-License-Identifier: Apache-2.0
// Unit power by a supply that speaks SCPI, against scpi_supply.py: a process of its own, strict about the syntax.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "hal/devices/chamber.h"
#include "hal/devices/unit_power.h"
#include "hal/maps/device_map.h"
#include "tests/errors.h"
#include "text_peer.h"

namespace soak::hal {
namespace {

class ScpiSupply : public test::TextPeer {
 public:
  explicit ScpiSupply(int port = 0) : TextPeer("scpi_supply.py", port) {}
};

using Address = std::variant<TcpAddress, SerialAddress>;

DeviceMap supply_map(const std::string& name, const Address& address) {
  const auto read = read_device_map(SOAK_TEST_FOLDER "/../procedures/power/" + name);
  if (!read) throw std::runtime_error(read.error().message);
  DeviceMap map = *read;
  map.link.address = address;
  map.link.response_timeout_s = 10.0;  // a busy machine lets the peer wait
  return map;
}

std::unique_ptr<UnitPower> made(const DeviceMap& map) {
  auto power = make_unit_power(map);
  if (!power) throw std::runtime_error(power.error().message);
  return *std::move(power);
}

using test::text_of;

OutputReading reading_of(UnitPower& power, int output) {
  const auto readings = power.read({output});
  EXPECT_TRUE(readings) << readings.error().message;
  return readings ? readings->at(output) : OutputReading{};
}

/// Over TCP, and over a serial line that socat makes of it.
class ScpiPowerTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    address_ = TcpAddress{"127.0.0.1", peer_.port()};
    if (std::string(GetParam()) == "serial") {
      SOAK_NEED_SOCAT();
      line_ = std::make_unique<test::SerialLine>(peer_.port());
      address_ = SerialAddress{line_->path(), 19200};
    }
    map_ = supply_map("scpi-supply.toml", address_);
    power_ = made(map_);
  }

  ScpiSupply peer_;
  std::unique_ptr<test::SerialLine> line_;
  Address address_;
  DeviceMap map_;
  std::unique_ptr<UnitPower> power_;
};

TEST_P(ScpiPowerTest, SwitchesOneOutputAtItsVoltageAndMeasuresIt) {
  (void)peer_.tell("load 2 50");
  ASSERT_EQ(text_of(power_->connect()), "");
  ASSERT_EQ(text_of(power_->prepare(2, {12.0, 0.5})), "");
  EXPECT_EQ(peer_.tell("state 2"), "off 0.000 0.000") << "what an output shall deliver does not switch it on";
  ASSERT_EQ(text_of(power_->set(2, true)), "");
  EXPECT_EQ(peer_.tell("state 2"), "on 12.000 0.240");
  EXPECT_EQ(peer_.tell("state 1"), "off 0.000 0.000");
  const OutputReading reading = reading_of(*power_, 2);
  EXPECT_TRUE(reading.on);
  EXPECT_FALSE(reading.tripped);
  EXPECT_EQ(reading.voltage_v, 12.0);
  EXPECT_EQ(reading.current_a, 0.24);
  EXPECT_EQ(reading.limit_a, 0.5);
  ASSERT_EQ(text_of(power_->set(2, false)), "");
  EXPECT_EQ(peer_.tell("state 2"), "off 0.000 0.000");
}

TEST_P(ScpiPowerTest, AsksOnceForAllOutputsAndReadsTheErrorQueueAfterAWrite) {
  ASSERT_EQ(text_of(power_->connect()), "");
  EXPECT_EQ(peer_.tell("log"), "*CLS;*OPC?");
  ASSERT_TRUE(power_->read({1, 2, 3}));
  EXPECT_EQ(
      peer_.tell("log"),
      "OUTP? (@1:3)|CURR:PROT:TRIP? (@1:3)|VOLT:PROT:TRIP? (@1:3)|MEAS:VOLT? (@1:3)|MEAS:CURR? (@1:3)|CURR? (@1:3)");
  ASSERT_EQ(text_of(power_->set(3, true)), "");
  EXPECT_EQ(peer_.tell("log"), "OUTP? (@1:3)|OUTP 1,(@3)|SYST:ERR?|OUTP? (@1:3)");
  ASSERT_EQ(text_of(power_->set(3, true)), "");
  EXPECT_EQ(peer_.tell("log"), "OUTP? (@1:3)") << "it is on already";
}

TEST_P(ScpiPowerTest, RefusesWhatTheMapDoesNotAllow) {
  ASSERT_EQ(text_of(power_->connect()), "");
  (void)peer_.tell("log");
  for (const SupplySettings& wanted :
       {SupplySettings{30.5, {}}, SupplySettings{{}, 5.5}, SupplySettings{std::nan(""), {}}}) {
    const auto refused = power_->prepare(1, wanted);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_TRUE(fails(power_->check(4, {}), base::ErrorKind::bad_input, {"'output_4'"}));
  EXPECT_EQ(peer_.tell("log"), "");
}

TEST_P(ScpiPowerTest, TellsWhatTheErrorQueueHolds) {
  map_.quantities.at("set_v_1").max = 99.0;
  power_ = made(map_);
  ASSERT_EQ(text_of(power_->connect()), "");
  const auto refused = power_->prepare(1, {99.0, {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(refused.error(), {"'VOLT 99.000,(@1)'", "-222"}));
  EXPECT_EQ(text_of(power_->prepare(1, {5.0, {}})), "") << "the link is sound, the queue is empty again";
}

TEST_P(ScpiPowerTest, ErrorsOfBeforeAreNotTakenForOurs) {
  (void)peer_.tell("error -221 Settings conflict");
  EXPECT_EQ(text_of(power_->set(1, true)), "") << "connecting has cleared them";
  (void)peer_.tell("error -221 Settings conflict");
  (void)peer_.tell("error -100 Command error");
  EXPECT_NE(text_of(power_->set(1, false)), "") << "nobody can tell whose they are";
  EXPECT_EQ(text_of(power_->set(1, false)), "") << "but they are told once";
  EXPECT_EQ(peer_.tell("state 1"), "off 0.000 0.000");
}

TEST_P(ScpiPowerTest, FindsASettingThatIsAcceptedAndIgnored) {
  (void)peer_.tell("stuck");
  EXPECT_TRUE(fails(power_->prepare(1, {12.0, {}}), base::ErrorKind::device,
                    {"set_v_1 (field 1 of 'VOLT? (@1:3)')", "12.000"}));
  EXPECT_TRUE(fails(power_->set(1, true), base::ErrorKind::device, {"output_1 (field 1 of 'OUTP? (@1:3)')"}));
}

TEST_P(ScpiPowerTest, TellsAnOutputThatWentOffByItself) {
  ASSERT_EQ(text_of(power_->prepare(1, {12.0, 0.5})), "");
  ASSERT_EQ(text_of(power_->set(1, true)), "");
  (void)peer_.tell("off 1");
  EXPECT_FALSE(reading_of(*power_, 1).on);
  EXPECT_FALSE(reading_of(*power_, 1).tripped) << "somebody pressed a key";
  ASSERT_EQ(text_of(power_->set(1, true)), "");
  (void)peer_.tell("trip 1");
  EXPECT_TRUE(reading_of(*power_, 1).tripped);
  EXPECT_NE(text_of(power_->set(1, true)), "") << "a protection is cleared by people, not by us";
}

TEST_P(ScpiPowerTest, TellsAnInrushThatTripsOrStaysAtTheLimit) {
  (void)peer_.tell("load 1 2");
  (void)peer_.tell("load 2 2");
  (void)peer_.tell("ocp 1");
  for (const int output : {1, 2}) ASSERT_EQ(text_of(power_->prepare(output, {12.0, 0.5})), "");
  EXPECT_NE(text_of(power_->set(1, true)), "");
  ASSERT_EQ(text_of(power_->set(2, true)), "");
  const auto readings = power_->read({1, 2});
  ASSERT_TRUE(readings) << readings.error().message;
  EXPECT_FALSE(readings->at(1).on);
  EXPECT_TRUE(readings->at(1).tripped);
  EXPECT_TRUE(readings->at(2).on);
  EXPECT_EQ(readings->at(2).current_a, readings->at(2).limit_a);
  EXPECT_EQ(readings->at(2).voltage_v, 1.0);
}

TEST_P(ScpiPowerTest, TheStandardsNotANumberIsNoMeasurement) {
  (void)peer_.tell("nan");
  const OutputReading reading = reading_of(*power_, 1);
  EXPECT_EQ(reading.voltage_v, std::nullopt);
  EXPECT_EQ(reading.current_a, std::nullopt);
  EXPECT_EQ(reading.limit_a, 1.0);
}

void expect_recovery(UnitPower& power) {
  using Readings = std::map<int, OutputReading>;
  test::expect_recovery<Readings>([&] { return power.read({1}); },
                                  [](const Readings& readings) {
                                    ASSERT_TRUE(readings.at(1).on);
                                    ASSERT_EQ(readings.at(1).voltage_v, 5.0);
                                    ASSERT_EQ(readings.at(1).current_a, 0.5);
                                  });
}

TEST_P(ScpiPowerTest, GivesTheTruthOrAnErrorAndRecoversFromEveryFault) {
  (void)peer_.tell("load 1 10");
  ASSERT_EQ(text_of(power_->prepare(1, {5.0, 1.0})), "");
  ASSERT_EQ(text_of(power_->set(1, true)), "");
  power_.reset();
  map_.link.response_timeout_s = 0.3;  // less than a late answer takes
  power_ = made(map_);
  for (const char* fault : {"late", "silence", "fragments", "cut", "garbage", "twice", "close"}) {
    SCOPED_TRACE(fault);
    if (std::string(fault) == "close" && line_) continue;  // socat would end
    (void)peer_.tell("fault fragments 2");
    (void)peer_.tell(fmt::format("then {} 1", fault));
    expect_recovery(*power_);
    if (HasFatalFailure()) return;
    (void)peer_.tell(fmt::format("fault {} 1", fault));
    (void)power_->set(1, true);
    expect_recovery(*power_);
    if (HasFatalFailure()) return;
  }
}

TEST_P(ScpiPowerTest, SelectsOutputsForASupplyWithoutChannelLists) {
  (void)peer_.tell("load 2 50");
  power_ = made(supply_map("scpi-supply-select.toml", address_));
  ASSERT_EQ(text_of(power_->prepare(2, {12.0, 0.5})), "");
  ASSERT_EQ(text_of(power_->set(2, true)), "");
  EXPECT_EQ(peer_.tell("state 2"), "on 12.000 0.240");
  EXPECT_EQ(peer_.tell("state 1"), "off 0.000 0.000");
  const auto readings = power_->read({1, 2});
  ASSERT_TRUE(readings) << readings.error().message;
  EXPECT_FALSE(readings->at(1).on);
  EXPECT_EQ(readings->at(1).voltage_v, 0.0);
  EXPECT_TRUE(readings->at(2).on);
  EXPECT_EQ(readings->at(2).current_a, 0.24);
}

INSTANTIATE_TEST_SUITE_P(Wires, ScpiPowerTest, ::testing::Values("tcp", "serial"),
                         [](const auto& info) { return std::string(info.param); });

TEST(ScpiPower, SaysThatACommandIsUnknownToTheSupply) {
  ScpiSupply peer;
  DeviceMap map = supply_map("scpi-supply.toml", TcpAddress{"127.0.0.1", peer.port()});
  map.quantities.at("output_1").text.write = "OUTPU {},(@1)";
  const auto refused = made(map)->set(1, true);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(names(refused.error(), {"'OUTPU 1,(@1)'", "-113"}));
}

TEST(ScpiPower, AChamberAndASupplyAreNotTakenForEachOther) {
  const DeviceMap map = supply_map("scpi-supply.toml", TcpAddress{"127.0.0.1", 1});
  const auto chamber = make_chamber(map);
  ASSERT_FALSE(chamber);
  EXPECT_TRUE(names(chamber.error(), {"\"power\"", "\"chamber\""}));
}

}  // namespace
}  // namespace soak::hal
