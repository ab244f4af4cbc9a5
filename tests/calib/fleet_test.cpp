// SPDX-License-Identifier: Apache-2.0
// Units of a type beside each other: figures by hand, and marks that chance does not set.
#include "calib/judge/fleet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "tests/long_tests.h"

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

/// So many units, one curve of each; any normal values of unit variance are a fleet whose units differ by chance alone.
std::vector<FleetMember> fleet_by_chance(int units, base::Random& random) {
  std::vector<FleetMember> members;
  for (int u = 0; u < units; ++u) members.push_back({level(random.gaussian()), {}});
  return members;
}

/// One unit for each value.
std::vector<FleetMember> levels(std::initializer_list<double> values, double ci95 = 0.0) {
  std::vector<FleetMember> members;
  for (const double value : values) members.push_back({level(value, ci95), {}});
  return members;
}

TEST(Fleet, StatesMedianAndSpreadAsCalculatedByHand) {
  std::vector<FleetMember> members;
  for (int value = 1; value <= 21; ++value) members.push_back({level(value), {}});
  const FleetSpread fleet = compare_fleet(members);
  EXPECT_EQ(fleet.temp_c.front(), -20.0);
  EXPECT_EQ(fleet.temp_c.back(), 60.0);
  EXPECT_EQ(fleet.temp_c.size(), 17U);
  for (std::size_t t = 0; t < fleet.temp_c.size(); ++t) {
    EXPECT_DOUBLE_EQ(fleet.median[t].value(), 11.0);
    EXPECT_DOUBLE_EQ(fleet.spread[t].value(), 1.4826 * 5.0);  // deviations 0, 1 1, 2 2 ... 10 10: median 5
  }
  EXPECT_DOUBLE_EQ(fleet.units[20].distance.value(), 10.0 / (1.4826 * 5.0));
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
  std::vector<FleetMember> members = fleet_by_chance(20, random);
  // Like the others in the middle, turned away at both ends: 16 standard deviations there.
  members[7].newest = curve([](double temp_c) { return 16.0 * (temp_c - 20.0) / 40.0; });
  const FleetSpread fleet = compare_fleet(members);
  for (std::size_t u = 0; u < members.size(); ++u) EXPECT_EQ(fleet.units[u].is_outlier(), u == 7) << u;
  EXPECT_EQ(std::abs(fleet.units[7].farthest_c.value() - 20.0), 40.0);
}

// Curves that are level are the worst case: no temperature makes up for another. Twelve of a unit are looked at, and
// few units tell their spread less well.
TEST(Fleet, SeldomMarksAUnitThatIsLikeTheOthersInAnyOfItsTwelveCurves) {
  SOAK_LONG_TEST();
  constexpr int kCurvesOfAUnit = 12;
  base::Random random(7);
  for (const auto& [units, most] : {std::pair(20, 0.012), std::pair(40, 0.004), std::pair(400, 0.001)}) {
    int marked = 0;
    const int fleets = 8000 / units;
    for (int f = 0; f < fleets; ++f) {
      std::vector<bool> stands_out(static_cast<std::size_t>(units));
      for (int c = 0; c < kCurvesOfAUnit; ++c) {
        const FleetSpread fleet = compare_fleet(fleet_by_chance(units, random));
        for (std::size_t u = 0; u < stands_out.size(); ++u) {
          if (fleet.units[u].is_outlier()) stands_out[u] = true;
        }
      }
      marked += static_cast<int>(std::ranges::count(stands_out, true));
    }
    const double rate = static_cast<double>(marked) / (units * fleets);
    RecordProperty("marked_of_" + std::to_string(units), std::to_string(rate));
    EXPECT_LT(rate, most) << "fleets of " << units;
  }
}

TEST(Fleet, WhatACurveIsUncertainByDoesNotSetItApart) {
  // All but one agree to a hundredth of their bands.
  const auto fleet = [](double ci95) {
    std::vector<FleetMember> members;
    for (int u = 0; u < 20; ++u) members.push_back({level(0.01 * (u % 3 - 1), ci95), {}});
    members.push_back({level(0.9, ci95), {}});
    return compare_fleet(members);
  };
  EXPECT_TRUE(fleet(0.0).units.back().is_outlier());
  EXPECT_FALSE(fleet(1.0).units.back().is_outlier());
}

TEST(Fleet, SaysNothingOfDistanceWhereThereAreFewUnitsOrTheyAreAllAlike) {
  std::vector<FleetMember> members(18, {level(1.0), {}});
  members.push_back({level(99.0), {}});
  const FleetSpread few = compare_fleet(members);
  EXPECT_DOUBLE_EQ(few.median[0].value(), 1.0);
  EXPECT_FALSE(few.spread[0]);
  EXPECT_FALSE(few.units.back().distance);
  EXPECT_FALSE(few.units.back().is_outlier());
  members.push_back({level(1.0), {}});
  const FleetSpread alike = compare_fleet(members);
  EXPECT_TRUE(alike.spread[0]);
  EXPECT_FALSE(alike.units[18].distance);
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

// Φ⁻¹(1 − 0.025/17) = 2.97382 and Φ⁻¹(0.975) = 1.95996: 17 temperatures are compared.
constexpr double kWidenedFor17 = 2.97382 / 1.95996;

TEST(Fleet, SaysWhereACurveHasMovedAndWhetherThatIsBeyondTheBands) {
  const auto bump = [](double temp_c) { return temp_c == 40.0 ? 1.0 : 0.1; };
  const FleetMember member{curve(bump, 0.3), level(0.0, 0.4)};
  const FleetSpread fleet = compare_fleet({member, {level(0.0), {}}});
  const FleetDrift drift = fleet.units[0].drift.value();
  EXPECT_EQ(drift.temp_c, 40.0);
  EXPECT_DOUBLE_EQ(drift.change, 1.0);
  EXPECT_NEAR(drift.band, 0.5 * kWidenedFor17, 1e-5);
  EXPECT_TRUE(drift.is_beyond_band());
  EXPECT_FALSE(fleet.units[1].drift) << "no model before";
  EXPECT_FALSE(compare_fleet({{level(0.7, 0.3), level(0.0, 0.4)}}).units[0].drift->is_beyond_band()) << "0.5 · 1.52";
}

TEST(Fleet, CurvesOfAUnitShareTheChanceOfAFalseAlarm) {
  const FleetMember one{level(1.0, 0.3), level(0.0, 0.4)};
  FleetMember of_twelve = one;
  of_twelve.curves = 12;
  const FleetSpread fleet = compare_fleet({one, of_twelve});
  // Φ⁻¹(1 − 0.025/204) = 3.66732
  EXPECT_NEAR(fleet.units[1].drift->band, 0.5 * 3.66732 / 1.95996, 1e-5);
}

// Bonferroni: at most 5 % of units that have not moved. Nine temperatures are independent here and eight lie between.
TEST(Fleet, SeldomSaysThatAUnitHasMovedThatHasNot) {
  constexpr int kUnits = 1000;
  base::Random random(11);
  const auto measured = [&] { return curve([&](double) { return random.gaussian(); }, 1.95996); };
  std::vector<bool> moved(kUnits);
  for (int c = 0; c < 12; ++c) {
    std::vector<FleetMember> members;
    for (int u = 0; u < kUnits; ++u) {
      FleetCurve newest = measured();
      members.push_back({std::move(newest), measured(), 12});
    }
    const FleetSpread fleet = compare_fleet(members);
    for (std::size_t u = 0; u < moved.size(); ++u) {
      if (fleet.units[u].drift->is_beyond_band()) moved[u] = true;
    }
  }
  const auto share = static_cast<double>(std::ranges::count(moved, true)) / kUnits;
  RecordProperty("moved_by_chance", std::to_string(share));
  EXPECT_LT(share, 0.05);
  EXPECT_GT(share, 0.01) << "a band so wide sees nothing";
}

}  // namespace
}  // namespace soak::calib
