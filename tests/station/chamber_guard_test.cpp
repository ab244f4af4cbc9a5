// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace soak::station {
namespace {

using std::chrono::seconds;

/// A chamber and a unit (rated −40 to 85 °C) that are looked at every ten seconds.
class ChamberGuardTest : public ::testing::Test {
 protected:
  ChamberGuardTest() {
    air.running = true;
    air.air_c = air.set_point_c = 60.0;
    air.output_percent = 12.0;
    unit = {"SN1", 65.0, -40.0, 85.0};
  }

  bool trips() {
    now_s += 10.0;
    host += seconds(10);
    const auto trouble = guard.look(now_s, host, answers ? &air : nullptr, std::span(&unit, 1));
    if (trouble) why = *trouble;
    return trouble.has_value();
  }
  /// Looks until it trips; the seconds that took, or nothing within `limit_s`. `step` changes what is seen before each
  /// look.
  template <class Change>
  std::optional<double> trips_within(double limit_s, Change step) {
    const double begin_s = now_s;
    while (now_s - begin_s < limit_s) {
      step();
      if (trips()) return now_s - begin_s;
    }
    return std::nullopt;
  }
  std::optional<double> trips_within(double limit_s) {
    return trips_within(limit_s, [this] { air.air_c = 60.0 + 0.01 * (static_cast<int>(now_s / 10.0) % 2); });
  }

  ChamberGuard guard;
  hal::ChamberReading air;
  GuardedUnit unit;
  bool answers = true;
  double now_s = 1000.0;
  ChamberGuard::HostTime host{};
  std::string why;
};

TEST_F(ChamberGuardTest, ADayAtASetPointTripsNothing) { EXPECT_FALSE(trips_within(86400.0)); }

TEST_F(ChamberGuardTest, AUnitBeyondItsRatingTripsWithinHalfAMinuteWhateverTheChamberSays) {
  unit.temp_c = 90.5;
  EXPECT_LE(trips_within(3600.0).value_or(3600.0), 30.0);
  EXPECT_NE(why.find("SN1"), std::string::npos);
  guard.forget();
  answers = false;
  EXPECT_LE(trips_within(3600.0).value_or(3600.0), 30.0);
  guard.forget();
  unit.temp_c = -45.5;
  EXPECT_LE(trips_within(3600.0).value_or(3600.0), 30.0);
}

TEST_F(ChamberGuardTest, AUnitWithinTheMarginOfItsRatingOrWithoutARatingIsLeftAlone) {
  unit.temp_c = 84.0;
  EXPECT_FALSE(trips_within(7200.0));
  unit = {"SN1", 84.9, std::nullopt, std::nullopt};
  EXPECT_FALSE(trips_within(7200.0));
}

TEST_F(ChamberGuardTest, AWrongNumberInBetweenTripsNothing) {
  int look = 0;
  EXPECT_FALSE(trips_within(7200.0, [&] {
    unit.temp_c = ++look % 7 < 2 ? 300.0 : 65.0;
    air.air_c = 60.0 + 0.01 * (look % 2);
  }));
}

TEST_F(ChamberGuardTest, AUnitThatHeatsFasterThanAnyChamberTrips) {
  air.set_point_c = 80.0;
  EXPECT_FALSE(trips_within(120.0, [this] { air.air_c += 1.5, unit.temp_c = -30.0 + 1.5 / 60.0 * now_s; }));
  guard.forget();
  unit.temp_c = -30.0;
  EXPECT_LE(trips_within(240.0, [this] { unit.temp_c += 25.0 / 6.0; }).value_or(240.0), 100.0);
}

TEST_F(ChamberGuardTest, AUnitFarFromTheAirTripsOnlyOnceTheAirHasStood) {
  unit.temp_c = 60.0 - 32.0;
  const double after_s = trips_within(7200.0).value_or(0.0);
  EXPECT_GE(after_s, 1800.0);
  EXPECT_LE(after_s, 1900.0);
  guard.forget();
  unit.temp_c = 60.0 + 15.0;  // warmed by itself
  EXPECT_FALSE(trips_within(7200.0));
}

TEST_F(ChamberGuardTest, AReadingThatIsLateByASecondOfAFastClockIsNotApart) {
  unit.temp_c = 60.0 - 32.0;
  for (int i = 0; i < 800; ++i) {
    now_s += 100.0;
    host += std::chrono::milliseconds(5);
    air.air_c = 60.0 + 0.01 * (i % 2);
    const bool late_only = host.time_since_epoch() <= seconds(2);
    EXPECT_FALSE(guard.look(now_s, host, &air, std::span(&unit, 1)).has_value() && late_only) << i;
  }
  EXPECT_TRUE(guard.look(now_s, host, &air, std::span(&unit, 1)).has_value());
}

TEST_F(ChamberGuardTest, AnAirThatStandsStillFarFromItsSetPointTripsAfterTenMinutes) {
  air.air_c = 34.0;
  const double after_s = trips_within(7200.0, [] {}).value_or(0.0);
  EXPECT_GE(after_s, 600.0);
  EXPECT_LE(after_s, 630.0);
}

TEST_F(ChamberGuardTest, AnAirThatMovesOrIsNotDrivenOrIsThereMayStand) {
  air.air_c = 34.0;
  unit.temp_c = 36.0;
  double step = 0.01;
  EXPECT_FALSE(trips_within(7200.0, [&] { air.air_c += step = -step; }));
  air.output_percent = 1.0;
  EXPECT_FALSE(trips_within(7200.0, [] {}));
  air.output_percent = 100.0;
  air.running = false;
  EXPECT_FALSE(trips_within(7200.0, [] {}));
  air.running = true;
  air.output_percent = 80.0;
  air.air_c = 59.0;
  EXPECT_FALSE(trips_within(7200.0, [] {}));
  air.air_c = 34.0;
  air.working_set_point_c = 34.5;  // the controller's ramp has just begun
  EXPECT_FALSE(trips_within(7200.0, [] {}));
}

TEST_F(ChamberGuardTest, AFrozenThermometerAtTheSetPointTripsOnceTheControllerDrivesAllItHas) {
  // The controller sees 0.4 K too little for ever, and its integral part runs away.
  air.air_c = 59.6;
  air.output_percent = 12.0;
  EXPECT_FALSE(trips_within(3600.0, [] {})) << "a coarse thermometer of a settled chamber";
  air.output_percent = 100.0;
  const double after_s = trips_within(7200.0, [] {}).value_or(0.0);
  EXPECT_GE(after_s, 600.0);
  EXPECT_LE(after_s, 630.0);
  guard.forget();
  air.output_percent = -100.0;
  EXPECT_TRUE(trips_within(700.0, [] {})) << "cooling runs away as heating does";
  guard.forget();
  air.output_percent = std::nullopt;
  EXPECT_FALSE(trips_within(7200.0, [] {})) << "where the map reads no output, nobody knows";
}

TEST_F(ChamberGuardTest, FullHeatingForAnHourAtTheSetPointTripsAlthoughTheAirMoves) {
  air.output_percent = 99.0;
  const double after_s = trips_within(7200.0).value_or(0.0);
  EXPECT_GE(after_s, 3600.0);
  EXPECT_LE(after_s, 3640.0);
}

TEST_F(ChamberGuardTest, FullHeatingOnTheWayOrInBetweenAndFullCoolingMayBe) {
  int look = 0;
  EXPECT_FALSE(trips_within(14400.0, [&] {
    air.output_percent = ++look % 100 == 0 ? 80.0 : 100.0;
    air.air_c = 60.0 + 0.01 * (look % 2);
  }));
  EXPECT_FALSE(trips_within(14400.0, [&] {
    air.output_percent = 100.0;
    air.air_c = 50.0 + 0.01 * (++look % 2);
  }));
  guard.forget();
  air.set_point_c = -60.0;
  unit.temp_c = -35.0;
  EXPECT_FALSE(trips_within(14400.0, [&] {
    air.output_percent = -100.0;  // a chamber at its lowest temperature
    air.air_c = -60.0 + 0.01 * (++look % 2);
  }));
}

TEST_F(ChamberGuardTest, AFastClockDoesNotMakeAReadingStandStill) {
  air.air_c = 34.0;
  for (int i = 0; i < 1000; ++i) {
    now_s += 100.0;
    host += std::chrono::milliseconds(4);
    EXPECT_EQ(guard.look(now_s, host, &air, {}).has_value(), host.time_since_epoch() > seconds(5)) << i;
    if (host.time_since_epoch() >= seconds(4)) break;
  }
}

}  // namespace
}  // namespace soak::station
