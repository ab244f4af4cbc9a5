// SPDX-License-Identifier: Apache-2.0
// What the driver promises of every unit, whichever protocol it speaks. What only one protocol has is tested in
// xsens_*, vectornav_* and ahrs400_stream_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/errors.h"
#include "tests/hal/unit_benches.h"

namespace soak::hal::imu::test {
namespace {

template <class Bench>
class UnitProtocol : public ::testing::Test {
 protected:
  /// Opens and lets the unit be configured.
  void start() {
    ASSERT_TRUE(bench.open());
    ASSERT_TRUE(bench.pass(2.0, 0.05));
    ASSERT_EQ(bench.imu->state(), ImuState::streaming);
    ASSERT_TRUE(bench.streams());
    bench.unit.heard.clear();
  }

  /// Host and unit live through `count` packets, each of which arrives `copies` times.
  void stream(int count, int copies = 1) {
    for (int i = 0; i < count; ++i) {
      advance(1);
      const Bytes packet = bench.unit.packets(1);
      for (int copy = 0; copy < copies && bench.streams(); ++copy) bench.send(packet);
      ASSERT_TRUE(bench.step());
    }
  }

  /// The unit sends `count` packets that do not arrive.
  void lose(int count) {
    static_cast<void>(bench.unit.packets(count));
    advance(count);
  }

  void advance(int packets) {
    bench.now +=
        std::chrono::round<typename Bench::Clock::duration>(std::chrono::duration<double>(packets * Bench::kStep_s));
  }

  [[nodiscard]] double span_s() const { return bench.samples.back().t_s - bench.samples.front().t_s; }
  [[nodiscard]] const ImuStatistics& statistics() const { return bench.imu->statistics(); }

  Bench bench;
};

class ProtocolNames {
 public:
  template <class Bench>
  static std::string GetName(int /*index*/) {
    if (std::is_same_v<Bench, XsensBench>) return "Xsens";
    return std::is_same_v<Bench, VectorNavBench> ? "VectorNav" : "Ahrs400";
  }
};

using Protocols = ::testing::Types<XsensBench, VectorNavBench, AhrsBench>;
TYPED_TEST_SUITE(UnitProtocol, Protocols, ProtocolNames);

TYPED_TEST(UnitProtocol, RatesThatNoUnitCanBeAskedForAreBadInput) {
  for (const double rate_hz : TypeParam::kImpossibleRates_hz) {
    const auto opened = this->bench.open({.rate_hz = rate_hz});
    ASSERT_FALSE(opened) << rate_hz;
    EXPECT_EQ(opened.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(this->bench.imu->state(), ImuState::closed);
  }
}

TYPED_TEST(UnitProtocol, AUnitWithoutPowerIsAskedOnceASecondAndNeverFails) {
  auto& bench = this->bench;
  bench.unit.answers = false;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(60.0, 0.05));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  EXPECT_NEAR(static_cast<double>(bench.unit.heard.size()), 60.0, 3.0);
  EXPECT_EQ(std::ranges::count(bench.unit.heard, bench.unit.heard.front()), std::ssize(bench.unit.heard));
  bench.unit.answers = true;
  ASSERT_TRUE(bench.pass(3.0, 0.05));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_TRUE(bench.streams());
  EXPECT_EQ(this->statistics().restarts, 0U);
}

TYPED_TEST(UnitProtocol, ALineThatBabblesButDoesNotAnswerFailsAfterThreeRepetitions) {
  auto& bench = this->bench;
  bench.unit.answers = false;
  ASSERT_TRUE(bench.open());
  base::Status status;
  for (int i = 0; i < 200 && status; ++i) {
    bench.send(hex("55 AA 12"));
    status = bench.pass(0.05, 0.05);
  }
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_EQ(status.error().where, bench.imu->description());
  EXPECT_TRUE(names(status.error(), {TypeParam::kFirstRequest}));
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
  EXPECT_EQ(bench.imu->wait_fd(), -1);
  EXPECT_EQ(bench.unit.heard.size(), TypeParam::kRequests);
}

TYPED_TEST(UnitProtocol, APacketThatIsSentAgainIsOneSample) {
  // A gateway that sends again what it has sent: a run file takes no two samples of one moment.
  this->start();
  this->stream(20);
  this->stream(40, 2);
  const auto& samples = this->bench.samples;
  EXPECT_EQ(samples.size(), 60U);
  for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_GT(samples[i].t_s, samples[i - 1].t_s) << i;
  EXPECT_EQ(this->statistics().packets, samples.size());
  EXPECT_EQ(this->statistics().lost_packets, 0U);
  EXPECT_EQ(this->statistics().restarts, 0U);
}

TYPED_TEST(UnitProtocol, LostPacketsAreCounted) {
  this->start();
  this->stream(50);
  this->lose(7);
  this->stream(50);
  EXPECT_EQ(this->bench.samples.size(), 100U);
  EXPECT_NEAR(this->span_s(), 106 * TypeParam::kStep_s, 1e-4);
  EXPECT_EQ(this->statistics().lost_packets, 7U);
  EXPECT_EQ(this->statistics().restarts, 0U);
}

TYPED_TEST(UnitProtocol, AStreamThatGoesOnByItselfAfterASilenceIsNoRestart) {
  auto& bench = this->bench;
  this->start();
  this->stream(50);
  bench.pause_unit(2.5);
  ASSERT_TRUE(bench.pass(2.5, 0.02));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  this->stream(5);
  EXPECT_EQ(bench.power_ons(), std::vector<std::uint32_t>(55, 0));
  EXPECT_TRUE(bench.unit.heard.empty());
}

TYPED_TEST(UnitProtocol, AUnitThatRestartedUnnoticedIsConfiguredAgainAndBeginsANewPowerOn) {
  auto& bench = this->bench;
  this->start();
  this->stream(500);
  bench.unit.answers = false;
  ASSERT_TRUE(bench.pass(60.0, 0.05));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  static_cast<void>((bench.unit.restart(), 0));
  bench.unit.answers = true;
  ASSERT_TRUE(bench.pass(2.5, 0.05));
  ASSERT_TRUE(bench.streams());
  this->stream(5);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_LT(bench.samples.back().t_s, 1.0);
  EXPECT_EQ(this->statistics().restarts, 1U);
}

TYPED_TEST(UnitProtocol, AnInterruptionOfTheLinkThatTheUnitStreamedThroughIsNoRestartAndNoLoss) {
  auto& bench = this->bench;
  this->start();
  this->stream(100);
  bench.imu->close();
  EXPECT_EQ(bench.imu->state(), ImuState::closed);
  this->lose(250);
  ASSERT_TRUE(bench.open());
  this->stream(150);
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.samples.back().power_on, 0U);
  EXPECT_NEAR(this->span_s(), 499 * TypeParam::kStep_s, 1e-3);
  EXPECT_EQ(this->statistics().lost_packets, 0U);
  EXPECT_EQ(this->statistics().restarts, 0U);
}

TYPED_TEST(UnitProtocol, AnotherUnitAfterAnInterruptionBeginsANewPowerOn) {
  auto& bench = this->bench;
  this->start();
  this->stream(5);
  bench.imu->close();
  const std::string serial = bench.exchange_unit();
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(2.0, 0.05));
  this->stream(5);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_EQ(bench.imu->identity()->serial, serial);
}

TYPED_TEST(UnitProtocol, AnUnplugIsADeviceErrorAndKeepsTheLastSamples) {
  auto& bench = this->bench;
  this->start();
  this->advance(5);
  bench.send(bench.unit.packets(5));
  bench.wire->far_end.reset();
  const auto status = bench.imu->poll(bench.samples);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_EQ(bench.samples.size(), 5U);
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
  EXPECT_EQ(bench.imu->wait_fd(), -1);
  EXPECT_FALSE(bench.imu->poll(bench.samples));
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(2.0, 0.05));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
}

}  // namespace
}  // namespace soak::hal::imu::test
