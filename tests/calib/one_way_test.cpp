// SPDX-License-Identifier: Apache-2.0
// Temperatures that were visited heating only, or cooling only: which they are, and what the bands hold there.
#include "calib/curve/one_way.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/curve/curve_fit.h"

namespace soak::calib {
namespace {

constexpr Sweep kUp = Sweep::up;
constexpr Sweep kDown = Sweep::down;
constexpr Sweep kUnknown = Sweep::unknown;

struct Visit {
  Sweep sweep;
  double temp_c;
};
using Path = std::vector<Visit>;

/// From one temperature to another in steps, both included.
Path way(double from_c, double to_c, double step_c) {
  Path path;
  const Sweep sweep = to_c > from_c ? kUp : kDown;
  const int steps = static_cast<int>(std::lround(std::abs(to_c - from_c) / step_c));
  for (int i = 0; i <= steps; ++i) path.push_back({sweep, from_c + (to_c > from_c ? i : -i) * step_c});
  return path;
}

Path operator+(Path first, const Path& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// Up from −30 °C and back without visiting the turning plateau twice. Nobody knows how the first was reached.
Path both_ways(double step_c) {
  Path path = way(-30.0, 70.0, step_c) + way(70.0 - step_c, -30.0, step_c);
  path.front().sweep = kUnknown;
  return path;
}

CurveData rows_of(const std::vector<Path>& runs) {
  CurveData data;
  for (const Path& path : runs) {
    const int run = static_cast<int>(data.runs.size());
    double t_s = 0.0;
    for (const Visit& visit : path) {
      CurveRow row;
      row.run = run;
      row.sweep = visit.sweep;
      row.t_s = t_s += 1800.0;
      row.temp_c = visit.temp_c;
      data.rows.push_back(row);
    }
    data.runs.push_back("R" + std::to_string(run + 1));
  }
  return data;
}

using Ranges = std::vector<OneWayRange>;

TEST(OneWay, ARunThatOnlyHeatsIsOneWayFromEndToEnd) {
  EXPECT_EQ(one_way_ranges(rows_of({way(-30.0, 70.0, 5.0)})), (Ranges{{-30.0, 70.0, kUp}}));
  EXPECT_EQ(one_way_ranges(rows_of({way(70.0, -30.0, 20.0)})), (Ranges{{-30.0, 70.0, kDown}}));
}

TEST(OneWay, BothWaysLeaveNothingHoweverFarThePlateausLieApart) {
  for (const double step_c : {2.5, 5.0, 10.0, 20.0, 25.0, 50.0}) {
    EXPECT_TRUE(one_way_ranges(rows_of({both_ways(step_c)})).empty()) << step_c;
  }
  // The two ways in different runs, and plateaus of the one way between those of the other.
  EXPECT_TRUE(one_way_ranges(rows_of({way(-30.0, 70.0, 5.0), way(70.0, -30.0, 5.0)})).empty());
  EXPECT_TRUE(one_way_ranges(rows_of({way(-30.0, 70.0, 10.0) + way(65.0, -25.0, 10.0)})).empty());
  // Back in wide steps: every 15 K is enough.
  EXPECT_TRUE(one_way_ranges(rows_of({way(-30.0, 60.0, 5.0) + way(45.0, -30.0, 15.0)})).empty());
}

TEST(OneWay, AReferencePlateauAtTheEndSpeaksForItsSurroundingsAlone) {
  // The shipped soak test: reference at 25 °C, −30 … 70 °C upwards, reference again. At −30 and 70 °C it turns.
  const Path path = Path{{kUnknown, 25.0}, {kDown, -30.0}} + way(-25.0, 70.0, 5.0) + Path{{kDown, 25.0}};
  EXPECT_EQ(one_way_ranges(rows_of({path, path})), (Ranges{{-22.5, 17.5, kUp}, {32.5, 62.5, kUp}}));
}

TEST(OneWay, WhereARunWasCutShortOnTheWayBackTheRestIsOneWay) {
  Path path = way(-30.0, 70.0, 5.0) + way(65.0, 30.0, 5.0);
  EXPECT_EQ(one_way_ranges(rows_of({path})), (Ranges{{-30.0, 22.5, kUp}}));
}

TEST(OneWay, RowsOfUnknownWayAndTurnsSayNothing) {
  EXPECT_TRUE(one_way_ranges({}).empty());
  EXPECT_TRUE(one_way_ranges(rows_of({{{kUnknown, 0.0}, {kUnknown, 20.0}, {kUnknown, 40.0}}})).empty());
  // Runs of one plateau each, reached from the room: none has an inner row.
  EXPECT_TRUE(one_way_ranges(rows_of({{{kDown, 0.0}}, {{kUp, 30.0}}, {{kUp, 50.0}}})).empty());
}

// ---- bands ----

constexpr double kGap = 0.05;           ///< deg/s between heating and cooling in the middle of the range
constexpr double kPowerOnSigma = 0.02;  ///< from power-on to power-on
constexpr double kRowSigma = 0.002;

/// Opening of the loop: closed where the way turns.
double lens(double temp_c) { return std::max(0.0, 1.0 - std::pow((temp_c - 20.0) / 50.0, 2)); }

/// What a unit reads on its way up (sign −1) or down (+1).
double branch_at(double temp_c, double sign) {
  return 0.1 + 0.25 * std::atan((temp_c - 15.0) / 25.0) + sign * 0.5 * kGap * lens(temp_c);
}

CurveData unit_rows(const Path& path, int runs, base::Random& random) {
  CurveData data = rows_of(std::vector<Path>(static_cast<std::size_t>(runs), path));
  std::vector<double> offsets;
  for (int run = 0; run < runs; ++run) {
    offsets.push_back(kPowerOnSigma * random.gaussian());
    for (const char* sweep : {" up", " down"}) {
      data.branches.push_back(data.runs[static_cast<std::size_t>(run)] + sweep);
    }
  }
  for (CurveRow& row : data.rows) {
    row.branch = 2 * row.run + (row.sweep == kDown ? 1 : 0);
    row.temp_c += 0.1 * random.gaussian();
    row.value = branch_at(row.temp_c, row.sweep == kDown ? 1.0 : -1.0) + offsets[static_cast<std::size_t>(row.run)] +
                kRowSigma * random.gaussian();
    row.standard_error = kRowSigma;
  }
  return data;
}

CurveFit fitted_curve(const CurveData& data, const KnownHysteresis& known = {}) {
  auto result = fit_curve(data, {5}, {"gyro_x", "deg/s", 1.0}, {}, known);
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

bool warns(const CurveFit& curve, const std::string& code) {
  return std::ranges::any_of(curve.warnings, [&](const Warning& warning) { return warning.code == code; });
}

TEST(OneWay, EveryUnitThatWasOnlyHeatedIsWarnedOfAndNoneThatWentBothWays) {
  base::Random random(21);
  for (int unit = 0; unit < 9; ++unit) {
    EXPECT_TRUE(warns(fitted_curve(unit_rows(way(-30.0, 70.0, 5.0), 3, random)), "one_way"));
    EXPECT_FALSE(warns(fitted_curve(unit_rows(both_ways(5.0), 3, random)), "one_way"));
  }
}

TEST(OneWay, WithoutAKnownHysteresisNoBandStatesOne) {
  base::Random random(22);
  const CurveFit unknown = fitted_curve(unit_rows(way(-30.0, 70.0, 5.0), 4, random));
  EXPECT_FALSE(unknown.budget[2].stated());
  EXPECT_EQ(unknown.one_way.known.source, HysteresisSource::none);
}

TEST(OneWay, AKnownHysteresisWidensBothBandsWhereOneWayWasRecordedAndNowhereElse) {
  base::Random random(23);
  const KnownHysteresis known{0.5 * kGap, HysteresisSource::type};
  Path cut = way(-30.0, 70.0, 5.0) + way(65.0, 30.0, 5.0);
  const CurveFit result = fitted_curve(unit_rows(cut, 4, random), known);
  const Contribution& part = result.budget[2];
  EXPECT_EQ(part.name, "hysteresis");
  EXPECT_EQ(part.type, 'B');
  ASSERT_EQ(result.one_way.ranges.size(), 1U);
  const std::vector<double> temps_c = temperatures_of(result);
  for (std::size_t i = 0; i < temps_c.size(); ++i) {
    const bool one_way = temps_c[i] >= result.one_way.ranges[0].low_c && temps_c[i] <= result.one_way.ranges[0].high_c;
    EXPECT_EQ(part.u[i], one_way ? 0.5 * kGap : 0.0);
    // the curve is one branch, half a gap from the mean; a power-on on the other branch is as far again
    if (one_way) {
      EXPECT_NEAR(part.u_fresh[i], std::sqrt(0.5) * kGap, 1e-3 * kGap);
    } else {
      EXPECT_LT(part.u_fresh[i], 0.5 * kGap);
    }
  }
  // A campaign that went both ways is left as it was.
  base::Random again(24);
  const CurveData whole = unit_rows(both_ways(5.0), 4, again);
  EXPECT_EQ(fitted_curve(whole, known).points[50].ci95, fitted_curve(whole).points[50].ci95);
  EXPECT_EQ(fitted_curve(whole, known).points[50].pi95, fitted_curve(whole).points[50].pi95);
}

TEST(OneWay, WithTheTypesValueTheBandsHoldTheOtherBranch) {
  // Heated only; judged on the way down, at one temperature a unit.
  base::Random random(25);
  int inside_mean = 0;
  int inside_fresh = 0;
  constexpr int kUnits = 40;
  for (int unit = 0; unit < kUnits; ++unit) {
    const CurveData data = unit_rows(way(-30.0, 70.0, 5.0), 3, random);
    const double temp_c = -25.0 + 90.0 * random.uniform();
    const double middle = branch_at(temp_c, 0.0);
    const double cooling = branch_at(temp_c, 1.0) + kPowerOnSigma * random.gaussian();
    const auto near = [&](const CurveFit& fitted) {
      return *std::ranges::min_element(fitted.points, {},
                                       [&](const CurvePoint& point) { return std::abs(point.temp_c - temp_c); });
    };
    const CurveFit stated = fitted_curve(data, {0.5 * kGap, HysteresisSource::type});
    inside_mean += std::abs(evaluate(stated.curve, temp_c) - middle) <= near(stated).ci95 ? 1 : 0;
    inside_fresh += std::abs(evaluate(stated.curve, temp_c) - cooling) <= *near(stated).pi95 ? 1 : 0;
  }
  // Of 40 units with bands that hold 95 %, one in a thousand has more than six outside.
  EXPECT_GE(inside_mean, kUnits - 6);
  EXPECT_GE(inside_fresh, kUnits - 6);
}

}  // namespace
}  // namespace soak::calib
