// SPDX-License-Identifier: Apache-2.0
// One recording in one attitude, without plateaus: cooling, heating, cooling, each over a range of its own and with an
// offset of its own. The mean curve over branches is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "calib/curve/curve_fit.h"

#include "tests/long_tests.h"

namespace soak::calib {
namespace {

struct RecordedBranch {
  double from_c;
  double to_c;
  double offset;
};

/// As the chamber's recording: two branches below 32 °C, three up to 45 °C, two above.
constexpr std::array kCycle = {RecordedBranch{45.0, 15.0, 0.0}, RecordedBranch{15.0, 70.0, 0.1},
                               RecordedBranch{70.0, 32.0, 0.75}};
constexpr double kMeanOffset = 0.85 / 3.0;
constexpr double kBlockNoise = 0.02;

double curve_of_cycle(double temp_c) { return 0.5 * std::atan((temp_c - 20.0) / 30.0); }
constexpr double kSteepest = 0.5 / 30.0;

CurveData record_cycle(unsigned seed) {
  constexpr int kBlocks = 60;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, kBlockNoise);
  CurveData data;
  data.by_plateau = false;
  data.runs = {"R1"};
  double t_s = 0.0;
  for (int b = 0; b < static_cast<int>(kCycle.size()); ++b) {
    const RecordedBranch& branch = kCycle[static_cast<std::size_t>(b)];
    data.branches.push_back("R1 branch " + std::to_string(b + 1));
    for (int i = 0; i < kBlocks; ++i) {
      const double temp_c = branch.from_c + (branch.to_c - branch.from_c) * (i + 0.5) / kBlocks;
      data.rows.push_back({0, b, branch.to_c > branch.from_c ? Sweep::up : Sweep::down, t_s += 30.0, temp_c,
                           curve_of_cycle(temp_c) + branch.offset + noise(engine), kBlockNoise});
    }
  }
  return data;
}

TEST(BranchOffsets, TheMeanCurveDoesNotStepWhereABranchEnds) {
  SOAK_LONG_TEST();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto fit = fit_curve(record_cycle(seed), {}, {"gyro_x", "deg/s", 1.0});
    ASSERT_TRUE(fit);
    for (std::size_t i = 1; i + 1 < fit->points.size(); ++i) {
      const double step = std::abs(fit->points[i].value - fit->points[i - 1].value);
      // The curve's own slope, and the noise of a mean of six blocks on either side.
      EXPECT_LT(step, kSteepest + 2.0 * kBlockNoise / std::sqrt(6.0))
          << "seed " << seed << " at " << fit->points[i].temp_c;
    }
  }
}

TEST(BranchOffsets, TheCurveIsTheMeanOverBranchesAndItsBandKnowsHowFarTheyLieApart) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto fit = fit_curve(record_cycle(seed), {}, {"gyro_x", "deg/s", 1.0});
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->run_to_run_sigma);
    EXPECT_FALSE(fit->points.front().pi95);
    EXPECT_LT(fit->lack_of_fit_sigma, kBlockNoise);
    for (const CurvePoint& point : fit->points) {
      const double error = std::abs(point.value - curve_of_cycle(point.temp_c) - kMeanOffset);
      // At the ends of the range the mean of few blocks of one branch bears the curve.
      EXPECT_LT(error, 3.0 * kBlockNoise) << "seed " << seed << " at " << point.temp_c;
      EXPECT_LE(error, point.ci95);
      // Three offsets with a standard deviation of 0.407: that of their mean is 0.235.
      EXPECT_GT(point.ci95, 0.235);
    }
  }
}

TEST(BranchOffsets, BranchesThatAgreeWidenNothing) {
  CurveData data = record_cycle(3);
  for (CurveRow& row : data.rows) row.value -= kCycle[static_cast<std::size_t>(row.branch)].offset;
  const auto fit = fit_curve(data, {}, {"gyro_x", "deg/s", 1.0});
  ASSERT_TRUE(fit);
  for (const CurvePoint& point : fit->points) EXPECT_LT(point.ci95, 2.0 * kBlockNoise) << point.temp_c;
}

}  // namespace
}  // namespace soak::calib
