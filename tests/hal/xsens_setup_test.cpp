// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/errors.h"
#include "tests/hal/unit_benches.h"

namespace soak::hal::imu::test {
namespace {

const std::vector<unsigned> kDialogue = {0x30, 0x00, 0x1C, 0x12, 0xC0, 0x10};

TEST(XsensSetup, IdentifiesAndConfiguresTheUnit) {
  XsensBench bench;
  EXPECT_EQ(bench.imu->state(), ImuState::closed);
  EXPECT_EQ(bench.imu->wait_fd(), -1);
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  EXPECT_FALSE(bench.imu->identity());
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.unit.heard, kDialogue);
  EXPECT_EQ(bench.unit.output_configuration,
            hex("10 20 FF FF 10 60 FF FF 40 20 00 64 80 20 00 64 08 10 00 0A E0 20 FF FF"));
  EXPECT_EQ(*bench.imu->identity(), (ImuIdentity{"0380ABCD", "MTi-300-AHRS", "1.8.2", false}));
  EXPECT_TRUE(bench.unit.measuring);
}

TEST(XsensSetup, AsksForTheRatesOfTheSettings) {
  XsensBench bench;
  ASSERT_TRUE(bench.open({.rate_hz = 400.0, .temp_rate_hz = 1.0}));
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.unit.output_configuration,
            hex("10 20 FF FF 10 60 FF FF 40 20 01 90 80 20 01 90 08 10 00 01 E0 20 FF FF"));
}

TEST(XsensSetup, AUnitThatSaysSoIsSimulated) {
  XsensBench bench;
  bench.unit.product = "SIMULATED MTi-30";
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.settle());
  EXPECT_TRUE(bench.imu->identity()->simulated);
}

TEST(XsensSetup, DataOfAnEarlierConfigurationAreDiscarded) {
  XsensBench bench;
  ASSERT_TRUE(bench.open());
  bench.send(bench.unit.packets(50));
  ASSERT_TRUE(bench.step());
  EXPECT_EQ(bench.imu->state(), ImuState::configuring);
  bench.send(bench.unit.packets(50));
  ASSERT_TRUE(bench.settle());
  EXPECT_TRUE(bench.samples.empty());
  bench.send(bench.unit.packets(1));
  ASSERT_TRUE(bench.step());
  ASSERT_EQ(bench.samples.size(), 1U);
  EXPECT_EQ(bench.samples[0].packet, 100U);
  EXPECT_EQ(bench.samples[0].power_on, 0U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST(XsensSetup, TheFirstWakeUpIsNoRestart) {
  XsensBench bench;
  ASSERT_TRUE(bench.open());
  bench.unit.answers = false;
  ASSERT_TRUE(bench.pass(5.0));
  bench.unit.answers = true;
  bench.send(bench.unit.restart());
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.imu->statistics().restarts, 0U);
}

TEST(XsensSetup, ALostRequestIsRepeatedFromTheFirstOneOn) {
  XsensBench bench;
  bench.unit.answers = true;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.step());  // answers the first request
  bench.unit.mute_times = 1;
  ASSERT_TRUE(bench.pass(3.0));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  const std::vector<unsigned> lost_one = {0x30, 0x00};
  ASSERT_EQ(bench.unit.heard.size(), lost_one.size() + kDialogue.size());
  EXPECT_TRUE(std::equal(kDialogue.begin(), kDialogue.end(), bench.unit.heard.begin() + 2));
}

TEST(XsensSetup, AUnitThatLosesPowerInTheMiddleIsSilentAndNotFailed) {
  XsensBench bench;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.step());
  ASSERT_TRUE(bench.step());
  bench.unit.answers = false;
  ASSERT_TRUE(bench.pass(30.0));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  EXPECT_EQ(bench.unit.heard.back(), 0x30U);
}

TEST(XsensSetup, AnErrorMessageFailsAndNamesItsCodeAndTheRequest) {
  XsensBench bench;
  bench.unit.error_upon = 0xC0;
  ASSERT_TRUE(bench.open());
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(status.error(), {"33", "(C0)"}));
  EXPECT_EQ(status.error().where, bench.imu->description());
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
}

TEST(XsensSetup, ARateThatDiffersByMoreThanOnePercentFails) {
  XsensBench bench;
  bench.unit.offered_share = 0.5;
  ASSERT_TRUE(bench.open());
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(status.error(), {"8020", "50 Hz", "100 Hz"}));
}

TEST(XsensSetup, ARateThatDiffersByOnePercentIsTaken) {
  for (const double share : {0.99, 1.01}) {
    XsensBench bench;
    bench.unit.offered_share = share;
    ASSERT_TRUE(bench.open());
    ASSERT_TRUE(bench.settle()) << share;
    EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  }
}

TEST(XsensSetup, AnOutputThatTheUnitDoesNotOfferIsNamed) {
  XsensSetup setup({});
  setup.begin();
  const auto answer = [&](Mid id, const Bytes& data) { return setup.take({.bus = 0xFF, .id = id, .data = data}); };
  ASSERT_TRUE(answer(Mid{0x31}, {}).value());
  ASSERT_TRUE(answer(Mid{0x01}, u32(1)).value());
  ASSERT_TRUE(answer(Mid{0x1D}, text("MTi")).value());
  ASSERT_TRUE(answer(Mid{0x13}, {1, 2, 3}).value());
  const auto status = answer(Mid{0xC1}, hex("10 20 FF FF 10 60 FF FF 40 20 00 64 80 20 00 64"));
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"0810"}));
}

TEST(XsensSetup, ADialogueGetsThroughGarbageBehindAFalseLongFrame) {
  XsensBench bench;
  ASSERT_TRUE(bench.open());
  bench.send(hex("FA FF 36 FF 1F F0 01 02 03"));
  ASSERT_TRUE(bench.pass(2.0));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 9U);
}

}  // namespace
}  // namespace soak::hal::imu::test
