// SPDX-License-Identifier: Apache-2.0
// Maps of chambers whose makers' protocols only public clients tell, against dialects_peer.py: a process that shares
// nothing with the driver. It was written from the same sources as the maps: it shows that driver and map say what the
// sources say, not that a chamber understands it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "hal/devices/chamber.h"
#include "hal/maps/device_map.h"
#include "tests/errors.h"
#include "text_peer.h"

namespace soak::hal {
namespace {

using test::text_of;

/// What goes over the wire, in hexadecimal.
struct Dialect {
  const char* map;
  const char* peer;
  std::string asks_air;
  std::string sets_minus_12_5;
  std::string starts;
  std::string stops;
  bool reads_limits;
  bool sets_while_standing;  ///< a set point counts before the chamber runs
};

std::string hex(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return text;
}

const Dialect kDialects[] = {
    {"simserv.toml", "simserv",
     hex("11004\xb6"
         "1\xb6"
         "1"),
     hex("11001\xb6"
         "1\xb6"
         "1\xb6"
         "-12.5"),
     hex("14001\xb6"
         "1\xb6"
         "1\xb6"
         "1"),
     hex("14001\xb6"
         "1\xb6"
         "1\xb6"
         "0"),
     true, true},
    {"cts.toml", "cts", hex("A0"), hex("a0 -12.5"), hex("s1 1"), hex("s1 0"), false, true},
    {"thermotron-8800.toml", "thermotron", hex("PVAR1?"), hex("SETP1,-12.5"), hex("RUNM"), hex("STOP"), false, false}};

class TextDialectTest : public ::testing::TestWithParam<Dialect> {
 protected:
  TextDialectTest() : peer_("dialects_peer.py", GetParam().peer) {
    auto map =
        read_device_map(std::string(SOAK_TEST_FOLDER "/../procedures/chambers/") + GetParam().map, MapUse::device);
    if (!map) throw std::runtime_error(map.error().message);
    map->link.address = TcpAddress{"127.0.0.1", peer_.port()};
    map->link.response_timeout_s = 5.0;  // a busy machine lets the peer wait
    map->link.gap_s = 0.0;
    map_ = *std::move(map);
    chamber_ = make_chamber(map_).value();
  }
  /// Commands since the last time.
  std::string log() { return "|" + peer_.tell("log") + "|"; }

  test::TextPeer peer_;
  DeviceMap map_;
  std::unique_ptr<Chamber> chamber_;
};

TEST_P(TextDialectTest, ReadsTheAirTheSetPointAndWhetherItRuns) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)log();
  auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NE(log().find("|" + GetParam().asks_air + "|"), std::string::npos);
  EXPECT_EQ(reading->air_c, 23.4);
  EXPECT_EQ(reading->set_point_c, 25.0);
  EXPECT_FALSE(reading->running);
  EXPECT_TRUE(reading->alarms.empty());
  (void)peer_.tell("set air -12.5");
  (void)peer_.tell("set on 1");
  reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->air_c, -12.5);
  EXPECT_TRUE(reading->running);
  if (GetParam().reads_limits) {
    EXPECT_EQ(chamber_->min_set_point_c(), -60.0);
    EXPECT_EQ(chamber_->max_set_point_c(), 150.0);
  }
}

TEST_P(TextDialectTest, StartsTakesASetPointAndStops) {
  ASSERT_EQ(text_of(chamber_->start()), "");
  EXPECT_NE(log().find("|" + GetParam().starts + "|"), std::string::npos);
  EXPECT_TRUE(chamber_->read()->running);
  (void)log();
  ASSERT_EQ(text_of(chamber_->set_temperature(-12.5)), "");
  EXPECT_NE(log().find("|" + GetParam().sets_minus_12_5 + "|"), std::string::npos);
  EXPECT_EQ(chamber_->read()->set_point_c, -12.5);
  (void)log();
  ASSERT_EQ(text_of(chamber_->stop()), "");
  EXPECT_NE(log().find("|" + GetParam().stops + "|"), std::string::npos);
  EXPECT_FALSE(chamber_->read()->running);
}

TEST_P(TextDialectTest, ASetPointThatIsGivenWhileItStandsHoldsOrIsSeenNotToHold) {
  ASSERT_EQ(text_of(chamber_->set_temperature(40.0)), "");
  EXPECT_EQ(chamber_->read()->set_point_c, GetParam().sets_while_standing ? 40.0 : 25.0);
}

TEST_P(TextDialectTest, AnErrorOfTheControllerSwitchesOff) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("set error 1");
  const auto reading = chamber_->read();
  ASSERT_TRUE(reading) << reading.error().message;
  ASSERT_EQ(reading->alarms.size(), 1U);
  EXPECT_TRUE(reading->alarms[0].outputs_off);
}

TEST_P(TextDialectTest, AsksAgainForAnAnswerThatIsNoText) {
  ASSERT_EQ(text_of(chamber_->connect()), "");
  (void)peer_.tell("broken 2");
  EXPECT_EQ(chamber_->read().value_or(ChamberReading{}).air_c, 23.4);
  (void)peer_.tell("broken 3");
  EXPECT_TRUE(is_device_error(chamber_->read()));
}

TEST_P(TextDialectTest, AnswersMayEndInCarriageReturnAlone) {
  (void)peer_.tell("ends cr");
  ASSERT_EQ(text_of(chamber_->connect()), "");
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(chamber_->read()) << i;
}

TEST_P(TextDialectTest, HasNoSecondConnectionUnlessTheMapSaysSo) { EXPECT_FALSE(map_.link.second_connection); }

INSTANTIATE_TEST_SUITE_P(Maps, TextDialectTest, ::testing::ValuesIn(kDialects),
                         [](const auto& info) { return std::string(info.param.peer); });

TEST(TextDialect, ARefusalOfSimServIsTold) {
  test::TextPeer peer("dialects_peer.py", "simserv");
  auto map = read_device_map(SOAK_TEST_FOLDER "/../procedures/chambers/simserv.toml").value();
  map.link.address = TcpAddress{"127.0.0.1", peer.port()};
  const auto chamber = make_chamber(map).value();
  ASSERT_EQ(text_of(chamber->connect()), "");
  (void)peer.tell("set high 40");  // after the limits were read
  const auto refused = chamber->set_temperature(60.0);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(names(refused.error(), {"'11001¶1¶1¶60.0'", "'-6'"})) << "in UTF-8, as people read it";
  EXPECT_TRUE(chamber->read()) << "the link is sound";
}

}  // namespace
}  // namespace soak::hal
