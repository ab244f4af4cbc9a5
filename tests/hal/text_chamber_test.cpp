// SPDX-License-Identifier: Apache-2.0
// The driver of chambers that speak text, against espec_peer.py: a process that shares nothing with the driver or with
// soaksim.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "hal/devices/detail/controller.h"
#include "hal/devices/survey.h"
#include "hal/maps/device_map.h"
#include "tests/errors.h"
#include "text_peer.h"

namespace soak::hal {
namespace {

class EspecLine : public test::TextPeer {
 public:
  explicit EspecLine(int port = 0) : TextPeer("espec_peer.py", port) {}
};

DeviceMap p300(const std::variant<TcpAddress, SerialAddress>& address) {
  const std::string file = SOAK_TEST_FOLDER "/../procedures/chambers/espec-p300.toml";
  auto map = read_device_map(file);
  if (!map) throw std::runtime_error(map.error().message);
  map->link.address = address;
  map->link.response_timeout_s = 10.0;  // a busy machine lets the peer wait
  return *std::move(map);
}

using test::text_of;

/// Over TCP, and over a serial line that socat makes of it.
class TextChamberTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    std::variant<TcpAddress, SerialAddress> address = TcpAddress{"127.0.0.1", peer_.port()};
    if (std::string(GetParam()) == "serial") {
      SOAK_NEED_SOCAT();
      line_ = std::make_unique<test::SerialLine>(peer_.port());
      address = SerialAddress{line_->path(), 19200};
    }
    map_ = p300(address);
    make_device();
  }

  /// Late answers and silence are what the test is about.
  void be_impatient() {
    map_.link.response_timeout_s = 0.3;
    make_device();
  }

  void make_device() {
    auto chamber = make_chamber(map_);
    ASSERT_TRUE(chamber) << chamber.error().message;
    chamber_ = *std::move(chamber);
  }

  EspecLine peer_;
  std::unique_ptr<test::SerialLine> line_;
  DeviceMap map_;
  std::unique_ptr<Chamber> chamber_;
};

TEST_P(TextChamberTest, AsksEachCommandOnceForAReading) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("log");
  ASSERT_TRUE(chamber_->read());
  EXPECT_EQ(peer_.tell("log"), "TEMP?|MODE?|ALARM?");
}

TEST_P(TextChamberTest, WritesASetPointWithTheDecimalsThatTheControllerTakes) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("log");
  ASSERT_EQ(text_of(chamber_->set_temperature(-40.25)), "");
  EXPECT_EQ(peer_.tell("log"), "TEMP?|TEMP, S-40.2|TEMP?");
  ASSERT_EQ(text_of(chamber_->set_temperature(-40.25)), "");
  EXPECT_EQ(peer_.tell("log"), "TEMP?") << "an unchanged set point is not written";
}

TEST_P(TextChamberTest, AProgramOfTheControllersOwnDoesNotHoldOurSetPoint) {
  ASSERT_EQ(text_of(chamber_->start()), "");
  EXPECT_TRUE(chamber_->read()->running);
  (void)peer_.tell("set mode RUN");
  EXPECT_FALSE(chamber_->read()->running);
}

TEST_P(TextChamberTest, TellsWhatTheControllerRefused) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("set high 40");  // after the limits were read
  const auto refused = chamber_->set_temperature(60.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(refused.error(), {"'TEMP, S60.0'", "'NA:DATA OUT OF RANGE'"}));
  EXPECT_TRUE(chamber_->read()) << "the link is sound, there is no pause";
}

TEST_P(TextChamberTest, IsToldToGoOffThoughItSaysThatItIsAndMayThenRefuse) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("log");
  ASSERT_EQ(text_of(chamber_->stop()), "");
  EXPECT_EQ(peer_.tell("log"), "MODE?|MODE,STANDBY|MODE?");
  (void)peer_.tell("fault fragments 1");
  (void)peer_.tell("then refuse 1");
  EXPECT_EQ(text_of(chamber_->stop()), "") << "it is off";
  (void)peer_.tell("set mode CONSTANT");
  (void)peer_.tell("fault fragments 1");
  (void)peer_.tell("then refuse 1");
  EXPECT_TRUE(fails(chamber_->stop(), base::ErrorKind::device, {"NA:CHB NOT READY"}));
}

TEST_P(TextChamberTest, FindsAWriteThatTheControllerAcceptsAndIgnores) {
  (void)peer_.tell("stuck");
  const auto status = chamber_->set_temperature(60.0);
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"set_point_c (field 2 of 'TEMP?')", "25.0", "60.0"}));
}

void expect_recovery(Chamber& chamber) {
  test::expect_recovery<ChamberReading>([&] { return chamber.read(); },
                                        [](const ChamberReading& reading) {
                                          ASSERT_EQ(reading.air_c, 23.2);
                                          ASSERT_EQ(reading.set_point_c, 25.0);
                                          ASSERT_FALSE(reading.running);
                                          ASSERT_TRUE(reading.alarms.empty());
                                        });
}

TEST_P(TextChamberTest, GivesTheTruthOrAnErrorAndRecoversFromEveryFault) {
  be_impatient();
  for (const char* fault : {"late", "later", "silence", "fragments", "cut", "garbage", "twice", "stale", "other",
                            "refuse", "endless", "close"}) {
    SCOPED_TRACE(fault);
    if (std::string(fault) == "close" && line_) continue;  // socat would end: see the test below
    for (const int good_before : {0, 1, 2}) {
      // The fault meets another of the three questions each time.
      (void)peer_.tell("fault none 0");
      expect_recovery(*chamber_);
      if (HasFatalFailure()) return;
      (void)peer_.tell(fmt::format("fault fragments {}", good_before));
      (void)peer_.tell(fmt::format("then {} 1", fault));
      expect_recovery(*chamber_);
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(TextChamberTest, ASurveyAsksOnceMoreWhereOneAnswerWasLost) {
  (void)peer_.tell("fault fragments 2");
  (void)peer_.tell("then silence 1");
  const auto survey = survey_chamber(map_);
  ASSERT_TRUE(survey) << survey.error().message;
  for (const SurveyEntry& entry : survey->entries) EXPECT_EQ(entry.trouble, "") << entry.name;
}

TEST_P(TextChamberTest, ReadsAnAnswerThatComesByteByByte) {
  (void)peer_.tell("fault fragments 10");
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, 23.2);
}

TEST_P(TextChamberTest, AsksNothingInThePauseAfterABadAnswer) {
  be_impatient();
  for (const char* fault : {"silence", "cut", "endless"}) {
    (void)peer_.tell("fault none 0");
    expect_recovery(*chamber_);
    if (HasFatalFailure()) return;
    (void)peer_.tell(fmt::format("fault {} 1", fault));
    const auto reading = chamber_->read();
    EXPECT_TRUE(is_device_error(reading)) << fault;
    (void)peer_.tell("log");
    EXPECT_TRUE(is_device_error(chamber_->read())) << "in the pause";
    EXPECT_EQ(peer_.tell("log"), "");
  }
}

TEST_P(TextChamberTest, AsksAgainAtOnceAfterAnAnswerThatWasSpoilt) {
  for (const char* fault : {"garbage", "twice"}) {
    ASSERT_EQ(text_of(chamber_->connect()), "");
    (void)peer_.tell("log");
    (void)peer_.tell(fmt::format("fault {} 2", fault));
    const auto reading = chamber_->read();
    ASSERT_TRUE(reading) << fault << ": " << reading.error().message;
    EXPECT_EQ(reading->air_c, 23.2);
    // Of two answers the first may come by itself: then it is the answer, and nothing is spoilt.
    const std::string asked = peer_.tell("log");
    if (std::string(fault) == "garbage") {
      EXPECT_EQ(asked, "TEMP?|TEMP?|TEMP?|MODE?|ALARM?");
    }
  }
}

TEST_P(TextChamberTest, AnAnswerWhoseTextWasSpoiltIsAskedForAgain) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("set mode C%NSTANT");  // for good: it is asked three times
  (void)peer_.tell("log");
  EXPECT_TRUE(is_device_error(chamber_->read()));
  EXPECT_EQ(peer_.tell("log"), "TEMP?|MODE?|MODE?|MODE?");
  (void)peer_.tell("set mode CONSTANT");
  EXPECT_TRUE(chamber_->read()) << "the link is sound, there is no pause";
}

INSTANTIATE_TEST_SUITE_P(Wires, TextChamberTest, ::testing::Values("tcp", "serial"),
                         [](const auto& info) { return std::string(info.param); });

TEST(TextChamber, ComesBackAfterTheAdapterWasPulledAndPluggedInAgain) {
  const EspecLine peer;
  SOAK_NEED_SOCAT();
  auto line = std::make_unique<test::SerialLine>(peer.port());
  const auto chamber = make_chamber(p300(SerialAddress{line->path(), 19200}));
  ASSERT_TRUE(chamber);
  expect_recovery(**chamber);
  line.reset();
  EXPECT_FALSE((*chamber)->read());
  line = std::make_unique<test::SerialLine>(peer.port());
  expect_recovery(**chamber);
}

TEST(TextChamber, EndsACallWhoseAnswersAllComeLateButInTime) {
  EspecLine peer;
  DeviceMap map = p300(TcpAddress{"127.0.0.1", peer.port()});
  map.link.response_timeout_s = 0.8;  // an answer comes after 0.6 s: a call may last 4 s
  for (int i = 0; i < 20; ++i) {
    map.alarms.push_back({.name = fmt::format("alarm {}", i),
                          .outputs_off = false,
                          .modbus = {},
                          .text = {{fmt::format("ALARM?{}", i), {}, 1}, {"0"}}});
  }
  map.refusals.clear();
  Controller controller(map);
  ASSERT_TRUE(controller.connect());
  (void)peer.tell("fault late 1000");
  const auto active = controller.active_alarms();
  EXPECT_TRUE(is_device_error(active));
}

TEST(TextChamber, PutsAnAddressBeforeEachCommandOnABus) {
  EspecLine peer;
  DeviceMap map = p300(TcpAddress{"127.0.0.1", peer.port()});
  map.link.prefix = "1,";
  (void)make_chamber(map).value()->connect();
  EXPECT_EQ(peer.tell("log"), "1,MODE?");
}

}  // namespace
}  // namespace soak::hal
