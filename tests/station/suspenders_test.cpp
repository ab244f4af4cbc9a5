// SPDX-License-Identifier: Apache-2.0
// The thresholds are those of the table in suspenders.h and docs/campaigns.md.
#include "station/lab/suspenders.h"

#include <gtest/gtest.h>

namespace soak::station {
namespace {

using Advice = Suspenders::Advice;
using Causes = std::vector<SuspensionCause>;

constexpr double kTwelveHours_s = 43200.0;

/// `silent_s`: host time.
StationConditions silent_chamber(double silent_s) {
  StationConditions conditions;
  conditions.chamber_silent_s = silent_s;
  return conditions;
}

StationConditions air_off(double kelvin) {
  StationConditions conditions;
  conditions.air_off_k = kelvin;
  return conditions;
}

StationConditions disk_free(double bytes) {
  StationConditions conditions;
  conditions.disk_free_bytes = bytes;
  return conditions;
}

StationConditions supply_at(double read_v) {
  StationConditions conditions;
  conditions.supplies = {{"A1", 12.0, 12.0}, {"A2", 12.0, read_v}};
  return conditions;
}

TEST(Suspenders, CarriesOnWhereAllIsWellOrNotKnown) {
  Suspenders suspenders(kTwelveHours_s);
  EXPECT_EQ(suspenders.look(0.0, {}), Advice::carry_on);
  EXPECT_EQ(suspenders.look(1e6, {}), Advice::carry_on);
  EXPECT_EQ(suspenders.causes(), Causes{});
  EXPECT_EQ(suspenders.text(), "");
  EXPECT_EQ(suspenders.suspended_since_s(), std::nullopt);
}

TEST(Suspenders, DoNotKeepWhenALinkIsTriedNext) {
  Suspenders suspenders(kTwelveHours_s);
  StationConditions silent = silent_chamber(61.0);
  silent.chamber_trouble = "10.0.0.7:502: timed out; next try in 8.0 s";
  EXPECT_EQ(suspenders.look(100.0, silent), Advice::suspend);
  EXPECT_TRUE(suspenders.text().ends_with("10.0.0.7:502: timed out")) << suspenders.text();
}

TEST(Suspenders, WaitForAChamberThatIsSilentForLongerThanAMinuteUntilItHasAnsweredForAnother) {
  Suspenders suspenders(kTwelveHours_s);
  EXPECT_EQ(suspenders.look(100.0, silent_chamber(0.1)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(159.9, silent_chamber(59.9)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(160.0, silent_chamber(60.0)), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::chamber});
  EXPECT_EQ(suspenders.suspended_since_s(), 160.0);
  EXPECT_EQ(suspenders.look(1360.0, {}), Advice::suspend);
  EXPECT_EQ(suspenders.look(1419.9, {}), Advice::suspend);
  EXPECT_EQ(suspenders.look(1420.0, {}), Advice::carry_on);
  EXPECT_EQ(suspenders.suspended_since_s(), std::nullopt);
}

TEST(Suspenders, DoNotCountSilencesThatAnAnswerSeparates) {
  Suspenders suspenders(kTwelveHours_s);
  for (double now_s = 0.0; now_s < 3600.0; now_s += 60.0) {
    EXPECT_EQ(suspenders.look(now_s, silent_chamber(0.1)), Advice::carry_on);
    EXPECT_EQ(suspenders.look(now_s + 59.0, silent_chamber(59.0)), Advice::carry_on);
    EXPECT_EQ(suspenders.look(now_s + 59.5, {}), Advice::carry_on);
  }
}

TEST(Suspenders, SettleAnewAfterEachRelapse) {
  Suspenders suspenders(kTwelveHours_s);
  (void)suspenders.look(0.0, silent_chamber(0.1));
  EXPECT_EQ(suspenders.look(60.0, silent_chamber(60.0)), Advice::suspend);
  for (double now_s = 100.0; now_s < 1000.0; now_s += 100.0) {
    EXPECT_EQ(suspenders.look(now_s, {}), Advice::suspend);
    EXPECT_EQ(suspenders.look(now_s + 59.0, {}), Advice::suspend);
    EXPECT_EQ(suspenders.look(now_s + 59.5, silent_chamber(0.1)), Advice::suspend);
  }
  EXPECT_EQ(suspenders.suspended_since_s(), 60.0);
}

TEST(Suspenders, GiveUpAfterTheLimitOfTheProcedure) {
  Suspenders suspenders(3600.0);
  (void)suspenders.look(0.0, silent_chamber(0.1));
  EXPECT_EQ(suspenders.look(60.0, silent_chamber(60.0)), Advice::suspend);
  EXPECT_EQ(suspenders.look(3660.0, silent_chamber(60.0)), Advice::suspend);
  EXPECT_EQ(suspenders.look(3660.1, silent_chamber(60.0)), Advice::give_up);
}

TEST(Suspenders, WaitForAirThatStaysAwayForTenMinutesUntilItIsBackWithinOneKelvin) {
  Suspenders suspenders(kTwelveHours_s);
  EXPECT_EQ(suspenders.look(0.0, air_off(3.1)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(599.0, air_off(20.0)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(600.0, air_off(20.0)), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::air});
  EXPECT_EQ(suspenders.look(900.0, air_off(2.0)), Advice::suspend);
  EXPECT_EQ(suspenders.look(5000.0, air_off(1.1)), Advice::suspend) << "between the thresholds nothing changes";
  EXPECT_EQ(suspenders.look(5001.0, air_off(1.0)), Advice::suspend);
  EXPECT_EQ(suspenders.look(5061.0, air_off(1.0)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(9000.0, air_off(2.9)), Advice::carry_on) << "nor do they suspend";
}

TEST(Suspenders, WaitAtOnceForRoomOnTheDiskUntilThereIsTwiceAsMuch) {
  Suspenders suspenders(kTwelveHours_s);
  EXPECT_EQ(suspenders.look(0.0, disk_free(50e6)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(1.0, disk_free(49.9e6)), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::disk});
  EXPECT_EQ(suspenders.look(1000.0, disk_free(99.9e6)), Advice::suspend);
  EXPECT_EQ(suspenders.look(2000.0, disk_free(100e6)), Advice::suspend);
  EXPECT_EQ(suspenders.look(2060.0, disk_free(100e6)), Advice::carry_on);
}

TEST(Suspenders, WaitWhereAWriteFailed) {
  Suspenders suspenders(kTwelveHours_s);
  StationConditions conditions;
  conditions.storage_error = "input/output error";
  EXPECT_EQ(suspenders.look(0.0, conditions), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::storage});
  EXPECT_EQ(suspenders.look(10.0, {}), Advice::suspend);
  EXPECT_EQ(suspenders.look(70.0, {}), Advice::carry_on);
}

TEST(Suspenders, WaitForTheCatalogWithoutSpoilingTheVisitUnlessSomethingElseHappens) {
  Suspenders suspenders(kTwelveHours_s);
  StationConditions conditions;
  conditions.catalog_error = "locked";
  EXPECT_EQ(suspenders.look(0.0, conditions), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::catalog});
  EXPECT_FALSE(suspenders.spoil_visit());
  conditions.disk_free_bytes = 0.0;
  EXPECT_EQ(suspenders.look(10.0, conditions), Advice::suspend);
  EXPECT_TRUE(suspenders.spoil_visit());
}

TEST(Suspenders, WaitForASupplyThatIsOffByATenthUntilItIsWithinATwentieth) {
  Suspenders suspenders(kTwelveHours_s);
  EXPECT_EQ(suspenders.look(0.0, supply_at(10.9)), Advice::carry_on) << "10.8 V is a tenth below";
  EXPECT_EQ(suspenders.look(5.0, supply_at(10.7)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(14.9, supply_at(13.3)), Advice::carry_on);
  EXPECT_EQ(suspenders.look(15.0, supply_at(13.3)), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::supply});
  EXPECT_EQ(suspenders.look(100.0, supply_at(12.7)), Advice::suspend) << "12.6 V is a twentieth above";
  EXPECT_EQ(suspenders.look(1000.0, supply_at(12.5)), Advice::suspend);
  EXPECT_EQ(suspenders.look(1060.0, supply_at(12.5)), Advice::carry_on);
}

TEST(Suspenders, GoOnOnlyOnceEveryCauseIsOver) {
  Suspenders suspenders(kTwelveHours_s);
  StationConditions both = silent_chamber(60.0);
  both.disk_free_bytes = 0.0;
  (void)suspenders.look(0.0, both);
  EXPECT_EQ(suspenders.look(60.0, both), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), (Causes{SuspensionCause::chamber, SuspensionCause::disk}));
  (void)suspenders.look(100.0, disk_free(0.0));
  EXPECT_EQ(suspenders.look(160.0, disk_free(0.0)), Advice::suspend);
  EXPECT_EQ(suspenders.causes(), Causes{SuspensionCause::disk});
  EXPECT_EQ(suspenders.suspended_since_s(), 0.0) << "one suspension from the first cause to the last";
}

TEST(Suspenders, GiveUpOnManyShortSuspensionsWithoutProgressAsOnALongOne) {
  Suspenders suspenders(3600.0);
  double now_s = 0.0;
  const auto suspend_for = [&](double seconds) {
    Advice advice = suspenders.look(now_s, disk_free(0.0));
    if (advice == Advice::suspend) advice = suspenders.look(now_s += seconds, disk_free(0.0));
    (void)suspenders.look(now_s, disk_free(1e9));
    (void)suspenders.look(now_s += Suspenders::kSettle_s, disk_free(1e9));
    now_s += 3000.0;  // the campaign is carried on meanwhile
    return advice;
  };
  EXPECT_EQ(suspend_for(1740.0), Advice::suspend);
  EXPECT_EQ(suspend_for(1740.0), Advice::suspend) << "half an hour, with the settling time, twice";
  EXPECT_EQ(suspend_for(10.0), Advice::give_up);
  suspenders = Suspenders(3600.0);
  EXPECT_EQ(suspend_for(1740.0), Advice::suspend);
  suspenders.note_progress();
  EXPECT_EQ(suspend_for(3500.0), Advice::suspend) << "with progress it is counted anew";
}

TEST(Suspenders, GiveUpAfterSoManySuspensionsWithoutProgress) {
  Suspenders suspenders(kTwelveHours_s);
  double now_s = 0.0;
  const auto suspend = [&] {
    const Advice advice = suspenders.look(now_s, disk_free(0.0));
    (void)suspenders.look(now_s += 1.0, disk_free(1e9));
    (void)suspenders.look(now_s += Suspenders::kSettle_s, disk_free(1e9));
    return advice;
  };
  for (int i = 0; i < Suspenders::kMostSuspensions; ++i) EXPECT_EQ(suspend(), Advice::suspend) << i;
  EXPECT_EQ(suspend(), Advice::give_up);
  suspenders.note_progress();
  EXPECT_EQ(suspend(), Advice::suspend);
}

TEST(Suspenders, DoNotTakeWhatIsNotKnownForTheEndOfACause) {
  StationConditions unknown_supply;
  unknown_supply.supplies = {{"A1", 12.0, std::nullopt}};
  Suspenders air(kTwelveHours_s);
  Suspenders disk(kTwelveHours_s);
  Suspenders supply(kTwelveHours_s);
  for (const double now_s : {0.0, 600.0}) {
    (void)air.look(now_s, air_off(20.0));
    (void)disk.look(now_s, disk_free(0.0));
    (void)supply.look(now_s, supply_at(10.0));
  }
  for (const double now_s : {700.0, 5000.0}) {
    EXPECT_EQ(air.look(now_s, {}), Advice::suspend);
    EXPECT_EQ(disk.look(now_s, {}), Advice::suspend);
    EXPECT_EQ(supply.look(now_s, unknown_supply), Advice::suspend);
  }
}

}  // namespace
}  // namespace soak::station
