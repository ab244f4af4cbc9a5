// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>

namespace soak::station {
namespace {

using namespace std::chrono_literals;

Procedure soak_procedure(double coldest_c, double hottest_c) {
  Procedure procedure;
  procedure.set_points_c = {20.0, coldest_c, hottest_c};
  return procedure;
}

// --- what is judged ---------------------------------------------------------------------------------------------

/// A campaign from -30 to +60 °C, read every ten seconds.
class WatchJudgeTest : public ::testing::Test {
 protected:
  bool trips(double air_c) {
    reading.air_c = air_c;
    return judge.look(now_s += 10.0, reading).has_value();
  }

  hal::ChamberReading reading;
  double now_s = 0.0;
  WatchJudge judge{watch_limits(soak_procedure(-30.0, 60.0), 15.0)};
};

TEST_F(WatchJudgeTest, LimitsAreTenKelvinBeyondSetPointsAndSafeTemperature) {
  const WatchLimits limits = watch_limits(soak_procedure(-30.0, 60.0), 15.0);
  EXPECT_EQ(limits.lowest_c, -40.0);
  EXPECT_EQ(limits.highest_c, 70.0);
  // A procedure in the cold ends in the warm all the same.
  EXPECT_EQ(watch_limits(soak_procedure(-30.0, 0.0), 15.0).highest_c, 35.0);
  EXPECT_EQ(watch_limits(soak_procedure(-30.0, 0.0), 24.0).highest_c, 38.0) << "4 K above the room's dew point";
}

TEST_F(WatchJudgeTest, TwoReadingsInARowBeyondALimitTrip) {
  EXPECT_FALSE(trips(20.0));
  EXPECT_FALSE(trips(70.1));
  EXPECT_TRUE(judge.suspects());
  EXPECT_FALSE(trips(20.0)) << "a single wrong number";
  EXPECT_FALSE(judge.suspects());
  EXPECT_FALSE(trips(-40.1));
  EXPECT_TRUE(trips(-40.1));
}

TEST_F(WatchJudgeTest, AChamberThatSomebodyLeftHotMayCoolDownButNotHeatOn) {
  for (double air_c = 90.0; air_c > 60.0; air_c -= 5.0) EXPECT_FALSE(trips(air_c)) << air_c;
  EXPECT_FALSE(trips(70.5));
  EXPECT_TRUE(trips(70.5)) << "it has been within its limits";
  WatchJudge other{watch_limits(soak_procedure(-30.0, 60.0), 15.0)};
  reading.air_c = 90.0;
  EXPECT_FALSE(other.look(10.0, reading));
  reading.air_c = 100.1;
  EXPECT_FALSE(other.look(20.0, reading));
  EXPECT_TRUE(other.look(30.0, reading));
}

TEST_F(WatchJudgeTest, AnAirThatMovesFasterThanAnyChamberTrips) {
  double air_c = -20.0;
  for (int i = 0; i < 18; ++i) EXPECT_FALSE(trips(air_c += 20.0 / 6.0)) << "the quickest chamber for units, twofold";
  WatchJudge other{WatchLimits{}};
  std::optional<int> tripped;
  for (int i = 1; i < 20 && !tripped; ++i) {
    reading.air_c = -20.0 + 7.5 * i;  // 45 K/min
    if (other.look(10.0 * i, reading)) tripped = i;
  }
  ASSERT_TRUE(tripped);
  EXPECT_GE(*tripped, 7) << "a minute at least";
  EXPECT_LE(*tripped, 10);
}

TEST_F(WatchJudgeTest, AWrongNumberBeforeAPauseOfTheLinkIsNoMovement) {
  EXPECT_FALSE(trips(20.0));
  reading.air_c = 100.0;
  EXPECT_FALSE(judge.look(now_s += 1.0, reading));
  now_s += 60.0;
  for (int i = 0; i < 10; ++i) {
    reading.air_c = 20.0;
    EXPECT_FALSE(judge.look(now_s += 1.0, reading)) << i;
  }
}

TEST_F(WatchJudgeTest, AnAlarmThatAsksForItTripsInTheSecondReading) {
  reading.alarms = {{"door", false}};
  EXPECT_FALSE(trips(20.0));
  EXPECT_FALSE(trips(20.0));
  reading.alarms = {{"over-temperature", true}};
  EXPECT_FALSE(trips(20.0));
  EXPECT_TRUE(judge.suspects());
  EXPECT_TRUE(trips(20.0));
}

// --- the thread -------------------------------------------------------------------------------------------------

/// What the chambers that a watch makes have in common: what they answer, and what they were told.
struct ChamberBench {
  std::mutex mutex;
  hal::ChamberReading says;
  std::string fault;          ///< of every reading; empty = none
  bool link_is_dead = false;  ///< nothing answers, stop() neither
  int lost_every = 0;         ///< so many reads: one of them gets no answer; 0 = all get one
  bool answered = true;       ///< the last read
  int reads = 0;
  int stops = 0;
  int made = 0;
  int open = 0;
  std::thread::id thread;

  template <class Work>
  auto with(Work work) {
    const std::lock_guard lock(mutex);
    return work(*this);
  }
};

class BenchChamber final : public hal::Chamber {
 public:
  explicit BenchChamber(ChamberBench& bench) : bench_(bench) {
    const std::lock_guard lock(bench_.mutex);
    ++bench_.made;
    ++bench_.open;
  }
  ~BenchChamber() override {
    const std::lock_guard lock(bench_.mutex);
    --bench_.open;
  }
  base::Status connect() override { return {}; }
  base::Result<hal::ChamberReading> read() override {
    const std::lock_guard lock(bench_.mutex);
    bench_.thread = std::this_thread::get_id();
    ++bench_.reads;
    const bool is_lost = bench_.lost_every > 0 && bench_.reads % bench_.lost_every == 0;
    bench_.answered = !bench_.link_is_dead && !is_lost;
    if (!bench_.answered) return base::fail(base::ErrorKind::device, "no answer");
    if (!bench_.fault.empty()) return base::fail(base::ErrorKind::device, bench_.fault);
    return bench_.says;
  }
  base::Status set_temperature(double) override { return base::fail(base::ErrorKind::internal, "a watch only stops"); }
  base::Status set_ramp_rate(std::optional<double>) override { return set_temperature(0.0); }
  base::Status start() override { return set_temperature(0.0); }
  base::Status stop() override {
    const std::lock_guard lock(bench_.mutex);
    if (bench_.link_is_dead) return base::fail(base::ErrorKind::device, "no answer");
    ++bench_.stops;
    bench_.says.running = false;
    return {};
  }
  [[nodiscard]] std::optional<double> min_set_point_c() const override { return {}; }
  [[nodiscard]] std::optional<double> max_set_point_c() const override { return {}; }
  [[nodiscard]] bool can_ramp() const override { return false; }
  [[nodiscard]] bool answers() const override {
    const std::lock_guard lock(bench_.mutex);
    return bench_.answered;
  }
  [[nodiscard]] std::string description() const override { return "bench"; }

 private:
  ChamberBench& bench_;
};

class ChamberWatchTest : public ::testing::Test {
 protected:
  ChamberWatchTest() {
    bench.says.running = true;
    bench.says.air_c = bench.says.set_point_c = 60.0;
    limits = watch_limits(soak_procedure(-30.0, 60.0), 15.0);
  }

  /// Waits until it holds, for a minute at most: the machine may be busy.
  static bool comes(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  int stops() {
    return bench.with([](ChamberBench& b) { return b.stops; });
  }
  bool is_read() const { return watch.verdict().reading.has_value(); }

  ChamberBench bench;
  WatchLimits limits;
  std::atomic<int> told = 0;  ///< of a trip
  std::atomic<bool> told_outputs_off = false;
  ChamberWatch watch{[this] { return std::make_unique<BenchChamber>(bench); }, 1.0, 100.0,
                     [this](bool outputs_off) {
                       ++told;
                       told_outputs_off = outputs_off;
                     }};
};

TEST_F(ChamberWatchTest, HasAConnectionOfItsOwnOnAThreadOfItsOwnOnlyWhileItIsArmed) {
  EXPECT_EQ(bench.with([](ChamberBench& b) { return b.made; }), 0);
  watch.arm(limits);
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return is_read(); }));
  EXPECT_EQ(bench.with([](ChamberBench& b) { return b.made; }), 1);
  EXPECT_NE(bench.with([](ChamberBench& b) { return b.thread; }), std::this_thread::get_id());
  EXPECT_LT(*watch.verdict().age_s, 60.0);
  watch.disarm();
  EXPECT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return b.open; }) == 0; }));
  EXPECT_EQ(stops(), 0);
}

TEST_F(ChamberWatchTest, SwitchesOffAnOverheatingChamberWhileNobodyAsks) {
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return is_read(); }));
  EXPECT_EQ(told, 0);
  bench.with([](ChamberBench& b) { b.says.air_c = 75.0; });
  // From here on this thread, which is the engine's, does nothing but look at the chamber.
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return !b.says.running; }); }));
  ASSERT_TRUE(comes([&] { return watch.verdict().is_off; }));
  EXPECT_NE(watch.verdict().tripped, "");
  EXPECT_GE(told, 1);
  EXPECT_TRUE(told_outputs_off);
}

TEST_F(ChamberWatchTest, SwitchesOffAgainWhatIsSwitchedOnAfterATripUntilItIsDisarmed) {
  watch.arm(limits);
  watch.stop_now("asked");
  ASSERT_TRUE(comes([&] { return watch.verdict().is_off; }));
  EXPECT_EQ(watch.verdict().tripped, "asked");
  bench.with([](ChamberBench& b) { b.says.running = true; });  // an engine that knows nothing of it yet
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return !b.says.running; }); }));
  watch.disarm();
  EXPECT_EQ(watch.verdict().tripped, "");
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return b.open; }) == 0; }));
  const int before = stops();
  bench.with([](ChamberBench& b) { b.says.running = true; });
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return is_read(); }));
  EXPECT_EQ(stops(), before);
}

TEST_F(ChamberWatchTest, AStopReachesTheChamberOnceItsLinkIsBack) {
  bench.link_is_dead = true;
  watch.arm(limits);
  watch.stop_now("asked");
  ASSERT_TRUE(comes([&] { return !watch.verdict().trouble.empty(); }));
  EXPECT_FALSE(watch.verdict().is_off);
  bench.with([](ChamberBench& b) { b.link_is_dead = false; });
  EXPECT_TRUE(comes([&] { return watch.verdict().is_off; }));
}

TEST_F(ChamberWatchTest, ADeadLinkAloneTripsNothing) {
  limits.longest_unreadable = 20ms;
  bench.link_is_dead = true;
  watch.arm(limits);
  // Ten looks are 50 ms apart and more: far beyond the limit.
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return b.reads; }) >= 10; }));
  EXPECT_NE(watch.verdict().trouble, "");
  EXPECT_EQ(watch.verdict().tripped, "") << "the campaign waits for its link, and goes on";
}

TEST_F(ChamberWatchTest, AControllerThatAnswersNonsenseForTooLongIsSwitchedOff) {
  limits.longest_unreadable = 100ms;
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return is_read(); }));
  bench.with([](ChamberBench& b) { b.fault = "air_c reads nan"; });
  ASSERT_TRUE(comes([&] { return stops() > 0; }));
  EXPECT_NE(watch.verdict().tripped, "");
}

TEST_F(ChamberWatchTest, NonsenseCountsOnWhereTheLinkIsLostNowAndThen) {
  limits.longest_unreadable = 300ms;  // looks are 50 ms apart and more
  bench.lost_every = 3;
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return is_read(); }));
  bench.with([](ChamberBench& b) { b.fault = "air_c reads nan"; });
  ASSERT_TRUE(comes([&] { return stops() > 0; }));
  EXPECT_NE(watch.verdict().tripped, "");
}

TEST_F(ChamberWatchTest, ALinkThatWasDeadForLongDoesNotMakeOneWrongAnswerALongOne) {
  limits.longest_unreadable = 10s;
  bench.link_is_dead = true;
  watch.arm(limits);
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return b.reads; }) >= 10; }));
  bench.with([](ChamberBench& b) {
    b.link_is_dead = false;
    b.fault = "air_c reads nan";
    b.reads = 0;
  });
  ASSERT_TRUE(comes([&] { return bench.with([](ChamberBench& b) { return b.reads; }) >= 3; }));
  EXPECT_EQ(watch.verdict().tripped, "");
}

TEST_F(ChamberWatchTest, AnEngineThatDoesNotTurnForTooLongTrips) {
  limits.longest_engine_silence = 1s;
  watch.arm(limits);
  const auto until = std::chrono::steady_clock::now() + 3s;
  while (std::chrono::steady_clock::now() < until) {
    watch.note_engine();
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(stops(), 0);
  EXPECT_TRUE(comes([&] { return stops() > 0; }));
}

TEST(ChamberWatch, IsMadeForTcpAndWhereTheMapAllowsASecondConnection) {
  hal::DeviceMap map;
  map.link.address = hal::TcpAddress{"127.0.0.1", 502};
  map.link.second_connection = true;
  EXPECT_TRUE(ChamberWatch::make(map, 1.0));
  map.link.second_connection = false;
  EXPECT_FALSE(ChamberWatch::make(map, 1.0));
  map.link.second_connection = true;
  map.link.address = hal::SerialAddress{"/dev/ttyUSB0", 9600};
  EXPECT_FALSE(ChamberWatch::make(map, 1.0));
}

}  // namespace
}  // namespace soak::station
