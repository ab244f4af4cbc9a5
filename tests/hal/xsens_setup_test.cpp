// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/hal/xsens_bench.h"

namespace soak::hal::imu::test {
namespace {

const std::vector<unsigned> kDialogue = {0x30, 0x00, 0x1C, 0x12, 0xC0, 0x10};

TEST(XsensSetup, IdentifiesAndConfiguresTheUnit) {
  Bench bench;
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
  Bench bench;
  ASSERT_TRUE(bench.open({.rate_hz = 400.0, .temp_rate_hz = 1.0}));
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.unit.output_configuration,
            hex("10 20 FF FF 10 60 FF FF 40 20 01 90 80 20 01 90 08 10 00 01 E0 20 FF FF"));
}

TEST(XsensSetup, RatesThatNoUnitCanBeAskedForAreBadInput) {
  for (const double rate_hz : {0.0, 0.5, 100.5, 2001.0, -1.0}) {
    Bench bench;
    const auto opened = bench.open({.rate_hz = rate_hz});
    ASSERT_FALSE(opened) << rate_hz;
    EXPECT_EQ(opened.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(bench.imu->state(), ImuState::closed);
  }
}

TEST(XsensSetup, AUnitThatSaysSoIsSimulated) {
  Bench bench;
  bench.unit.product = "SIMULATED MTi-30";
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.settle());
  EXPECT_TRUE(bench.imu->identity()->simulated);
}

TEST(XsensSetup, DataOfAnEarlierConfigurationAreDiscarded) {
  Bench bench;
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

TEST(XsensSetup, AUnitWithoutPowerIsAskedOnceASecondAndNeverFails) {
  Bench bench;
  bench.unit.answers = false;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(600.0));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  EXPECT_NEAR(static_cast<double>(bench.unit.heard.size()), 600.0, 2.0);
  EXPECT_EQ(std::ranges::count(bench.unit.heard, 0x30U), std::ssize(bench.unit.heard));
  bench.unit.answers = true;
  ASSERT_TRUE(bench.pass(2.0));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
}

TEST(XsensSetup, TheFirstWakeUpIsNoRestart) {
  Bench bench;
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
  Bench bench;
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

TEST(XsensSetup, AUnitThatIsHeardButDoesNotAnswerFailsAfterThreeRepetitions) {
  Bench bench;
  bench.unit.answers = false;
  ASSERT_TRUE(bench.open());
  base::Status status;
  for (int i = 0; i < 100 && status; ++i) {
    bench.send(hex("55 AA 12"));
    status = bench.pass(0.1);
  }
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_NE(status.error().message.find("enter configuration"), std::string::npos) << status.error().message;
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
  EXPECT_EQ(bench.imu->wait_fd(), -1);
  EXPECT_EQ(bench.unit.heard, std::vector<unsigned>(4, 0x30));
}

TEST(XsensSetup, AUnitThatLosesPowerInTheMiddleIsSilentAndNotFailed) {
  Bench bench;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.step());
  ASSERT_TRUE(bench.step());
  bench.unit.answers = false;
  ASSERT_TRUE(bench.pass(30.0));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  EXPECT_EQ(bench.unit.heard.back(), 0x30U);
}

TEST(XsensSetup, AnErrorMessageFailsAndNamesItsCodeAndTheRequest) {
  Bench bench;
  bench.unit.error_upon = 0xC0;
  ASSERT_TRUE(bench.open());
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_NE(status.error().message.find("code 33"), std::string::npos) << status.error().message;
  EXPECT_NE(status.error().message.find("(C0)"), std::string::npos) << status.error().message;
  EXPECT_EQ(status.error().where, bench.imu->description());
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
}

TEST(XsensSetup, ARateThatDiffersByMoreThanOnePercentFails) {
  Bench bench;
  bench.unit.offered_share = 0.5;
  ASSERT_TRUE(bench.open());
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_NE(status.error().message.find("rate of turn (8020) at 50 Hz, not at the 100 Hz"), std::string::npos)
      << status.error().message;
}

TEST(XsensSetup, ARateThatDiffersByOnePercentIsTaken) {
  for (const double share : {0.99, 1.01}) {
    Bench bench;
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
  EXPECT_NE(status.error().message.find("temperature (0810)"), std::string::npos);
}

TEST(XsensSetup, ADialogueGetsThroughGarbageBehindAFalseLongFrame) {
  Bench bench;
  ASSERT_TRUE(bench.open());
  bench.send(hex("FA FF 36 FF 1F F0 01 02 03"));
  ASSERT_TRUE(bench.pass(2.0));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 9U);
}

}  // namespace
}  // namespace soak::hal::imu::test
