// SPDX-License-Identifier: Apache-2.0
// Units of a type beside each other: figures by hand, and marks that chance does not set.
#include "calib/judge/fleet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/random.h"

namespace soak::calib {
namespace {

/// A curve from −20 to 60 °C, a point at every tenth degree.
FleetCurve curve(const std::function<double(double)>& value, double ci95 = 0.0) {
  FleetCurve points;
  for (double temp_c = -20.0; temp_c <= 60.0; temp_c += 10.0) points.push_back({temp_c, value(temp_c), ci95});
  return points;
}

FleetCurve level(double value, double ci95 = 0.0) {
  return curve([=](double) { return value; }, ci95);
}

/// One unit for each value.
std::vector<FleetMember> levels(std::initializer_list<double> values, double ci95 = 0.0) {
  std::vector<FleetMember> members;
  for (const double value : values) members.push_back({level(value, ci95), {}});
  return members;
}

TEST(Fleet, StatesMedianAndSpreadAsCalculatedByHand) {
  const FleetSpread fleet = compare_fleet(levels({1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(fleet.temp_c.front(), -20.0);
  EXPECT_EQ(fleet.temp_c.back(), 60.0);
  EXPECT_EQ(fleet.temp_c.size(), 17U);
  for (std::size_t t = 0; t < fleet.temp_c.size(); ++t) {
    EXPECT_DOUBLE_EQ(fleet.median[t].value(), 5.0);
    EXPECT_DOUBLE_EQ(fleet.spread[t].value(), 1.4826 * 2.0);  // deviations 4 3 2 1 0 1 2 3 4: median 2
  }
  EXPECT_DOUBLE_EQ(fleet.units[8].distance.value(), 4.0 / (1.4826 * 2.0));
  EXPECT_TRUE(std::ranges::none_of(fleet.units, &FleetPlace::is_outlier));
}

TEST(Fleet, ReadsCurvesBetweenTheirPoints) {
  const auto line = [](double temp_c) { return 2.0 * temp_c; };
  const FleetSpread fleet = compare_fleet({{curve(line), {}}});
  for (std::size_t t = 0; t < fleet.temp_c.size(); ++t) {
    EXPECT_NEAR(fleet.units[0].values[t].value(), line(fleet.temp_c[t]), 1e-12);
  }
}

TEST(Fleet, MarksTheUnitThatIsNotLikeTheOthers) {
  base::Random random(1);
  std::vector<FleetMember> members;
  for (int u = 0; u < 20; ++u) members.push_back({level(random.gaussian()), {}});
  // Like the others in the middle, turned away at both ends: 8 standard deviations there.
  members[7].newest = curve([](double temp_c) { return 8.0 * (temp_c - 20.0) / 40.0; });
  const FleetSpread fleet = compare_fleet(members);
  for (std::size_t u = 0; u < members.size(); ++u) EXPECT_EQ(fleet.units[u].is_outlier(), u == 7) << u;
  EXPECT_EQ(std::abs(fleet.units[7].farthest_c.value() - 20.0), 40.0);
}

// A normal value lies beyond 3.5 standard deviations in 0.047 % of cases; few units tell their spread less well.
TEST(Fleet, SeldomMarksAUnitThatIsLikeTheOthers) {
  base::Random random(7);
  for (const auto& [units, most] : {std::pair(8, 0.04), std::pair(40, 0.005), std::pair(400, 0.001)}) {
    double marked = 0.0;
    const int fleets = 8000 / units;
    for (int f = 0; f < fleets; ++f) {
      std::vector<FleetMember> members;
      for (int u = 0; u < units; ++u) {
        const double offset = random.gaussian();
        const double twist = random.gaussian();
        members.push_back({curve([&](double temp_c) { return offset + twist * (temp_c - 20.0) / 40.0; }), {}});
      }
      const FleetSpread fleet = compare_fleet(members);
      marked += static_cast<double>(std::ranges::count_if(fleet.units, &FleetPlace::is_outlier));
    }
    RecordProperty("marked_of_" + std::to_string(units), std::to_string(marked / (units * fleets)));
    EXPECT_LT(marked / (units * fleets), most) << "fleets of " << units;
  }
}

TEST(Fleet, WhatACurveIsUncertainByDoesNotSetItApart) {
  // All but one agree to a hundredth of their bands.
  const std::initializer_list<double> values = {0.0, 0.01, -0.01, 0.0, 0.01, -0.01, 0.0, 0.01, 0.9};
  EXPECT_TRUE(compare_fleet(levels(values)).units[8].is_outlier());
  EXPECT_FALSE(compare_fleet(levels(values, 1.0)).units[8].is_outlier());
}

TEST(Fleet, SaysNothingOfDistanceWhereThereAreFewUnitsOrTheyAreAllAlike) {
  const FleetSpread few = compare_fleet(levels({1, 2, 3, 4, 5, 6, 99}));
  EXPECT_DOUBLE_EQ(few.median[0].value(), 4.0);
  EXPECT_FALSE(few.spread[0]);
  EXPECT_FALSE(few.units[6].distance);
  EXPECT_FALSE(few.units[6].is_outlier());
  EXPECT_FALSE(compare_fleet(levels({1, 1, 1, 1, 1, 1, 1, 1, 2})).units[8].distance);
}

TEST(Fleet, ComparesCurvesOnlyWhereTheyReach) {
  std::vector<FleetMember> members = levels({1, 2, 3, 4, 5, 6, 7, 8, 9});
  // As a chamber that settles 0.4 K off its set points, and one that goes further than all others.
  for (FleetPoint& point : members[0].newest) point.temp_c += 0.4;
  members[1].newest.push_back({100.0, 2.0, 0.0});
  members[2].newest = {{25.3, 3.0, 0.0}};
  const FleetSpread fleet = compare_fleet(members);
  ASSERT_EQ(fleet.temp_c.back(), 100.0);
  EXPECT_TRUE(fleet.units[0].values.front());
  EXPECT_FALSE(fleet.median.back()) << "one of nine";
  EXPECT_TRUE(fleet.units[1].values.back());
  EXPECT_EQ(std::ranges::count_if(fleet.units[2].values, [](const auto& value) { return value.has_value(); }), 1);
}

TEST(Fleet, AUnitWithoutACurveHasNoPlace) {
  std::vector<FleetMember> members = levels({1, 2});
  members.push_back({});
  const FleetSpread fleet = compare_fleet(members);
  EXPECT_DOUBLE_EQ(fleet.median[0].value(), 1.5);
  EXPECT_FALSE(fleet.units[2].values[0]);
  EXPECT_FALSE(fleet.units[2].drift);
  EXPECT_TRUE(compare_fleet({{}, {}}).temp_c.empty());
  EXPECT_TRUE(compare_fleet({}).units.empty());
}

TEST(Fleet, SaysWhereACurveHasMovedAndWhetherThatIsBeyondTheBands) {
  const auto bump = [](double temp_c) { return temp_c == 40.0 ? 1.0 : 0.1; };
  const FleetMember member{curve(bump, 0.3), level(0.0, 0.4)};
  const FleetSpread fleet = compare_fleet({member, {level(0.0), {}}});
  const FleetDrift drift = fleet.units[0].drift.value();
  EXPECT_EQ(drift.temp_c, 40.0);
  EXPECT_DOUBLE_EQ(drift.change, 1.0);
  EXPECT_DOUBLE_EQ(drift.band, 0.5);
  EXPECT_TRUE(drift.is_beyond_band());
  EXPECT_FALSE(fleet.units[1].drift) << "no model before";
  EXPECT_FALSE(compare_fleet({{level(0.4, 0.3), level(0.0, 0.4)}}).units[0].drift->is_beyond_band());
}

}  // namespace
}  // namespace soak::calib
