// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/reference_plateau.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/calib/six_position_samples.h"

namespace soak::calib {
namespace {

constexpr std::size_t kGyro = index_of(Sensor::gyro_x);
constexpr std::size_t kAccel = index_of(Sensor::accel_z);

/// A run up from the reference plateau and back to it; visit 3 is on the way.
test::Bench bench_with_references() {
  test::Bench bench;
  bench.plateaus_c = {25, -10, 10, 25, 40, 25};
  return bench;
}

RunInput run_of(const test::Bench& bench) {
  RunInput run;
  run.label = "R01";
  run.site = test::standard_site();
  run.segments = test::segments_of(bench);
  return run;
}

RunAtReference reference_of(const RunInput& run) { return reference_plateau(run, {}); }

/// Adds to every reading of a sensor during a visit.
void shift(RunInput& run, std::int32_t visit, std::size_t sensor, double by) {
  for (Segment& segment : run.segments) {
    if (segment.key.visit == visit) segment.sensor[sensor].mean += by;
  }
}

TEST(ReferencePlateau, ARunThatBeginsAndEndsThereHasItsDrift) {
  RunInput run = run_of(bench_with_references());
  shift(run, 5, kGyro, 2e-4);
  shift(run, 5, kAccel, -0.03);
  const RunAtReference reference = reference_of(run);
  EXPECT_TRUE(reference.at_both_ends);
  EXPECT_EQ(reference.visits, (std::vector<std::int32_t>{0, 5}));
  const SensorReference& gyro = reference.sensor[kGyro].value();
  const double truth = 0.01 + 1e-4 * 25.0;  // Bench::gyro_bias, which holds g-sensitivity no longer
  EXPECT_NEAR(gyro.drift->value, 2e-4, 1e-12);
  EXPECT_NEAR(gyro.first->value, truth, 1e-9);
  EXPECT_NEAR(gyro.last->value, truth + 2e-4, 1e-9);
  EXPECT_NEAR(gyro.bias.value, truth + 1e-4, 1e-9);
  EXPECT_EQ(gyro.temp_c, 25.0);
  EXPECT_NEAR(reference.sensor[kAccel]->drift->value, -0.03, 1e-9);
  // A sensor that nothing happened to.
  EXPECT_NEAR(reference.sensor[index_of(Sensor::gyro_y)]->drift->value, 0.0, 1e-12);
}

TEST(ReferencePlateau, StandardErrorOfADriftIsItsScatterOverRuns) {
  test::Bench bench = bench_with_references();
  bench.gyro_noise = 1e-4;
  bench.accel_noise = 1e-3;
  constexpr int kRuns = 400;
  double gyro = 0.0;
  double accel = 0.0;
  for (int i = 1; i <= kRuns; ++i) {
    bench.seed = static_cast<std::uint64_t>(i);
    const RunAtReference reference = reference_of(run_of(bench));
    const Estimate& g = reference.sensor[kGyro]->drift.value();
    const Estimate& a = reference.sensor[kAccel]->drift.value();
    gyro += std::pow(g.value / g.standard_error, 2) / kRuns;
    accel += std::pow(a.value / a.standard_error, 2) / kRuns;
  }
  // Mean square of 400 normal numbers: 1 ± 0.07 of scatter, four times that. The two biases share the run's couplings,
  // which cancel in the difference, so that the stated error may be too large; not by more than a third.
  EXPECT_LT(gyro, 1.28);
  EXPECT_LT(accel, 1.28);
  EXPECT_GT(gyro, 0.5);
  EXPECT_GT(accel, 0.5);
}

TEST(ReferencePlateau, ADifferenceOfTemperatureIsNoDrift) {
  test::Bench bench = bench_with_references();
  bench.plateaus_c = {25, 15, 20, 30, 25.4};  // 0.4 K at 1e-4 per K would be 4e-5
  RunInput run = run_of(bench);
  for (Segment& segment : run.segments) {
    if (segment.key.visit == 4) segment.plateau_c = 25.0;
  }
  const RunAtReference reference = reference_of(run);
  ASSERT_TRUE(reference.at_both_ends);
  EXPECT_NEAR(reference.sensor[kGyro]->slope_per_k.value(), 1e-4, 1e-9);
  EXPECT_NEAR(reference.sensor[kGyro]->drift->value, 0.0, 1e-9);
  EXPECT_NEAR(reference.sensor[kGyro]->temp_c, 25.2, 1e-9);
}

TEST(ReferencePlateau, WithoutReferenceVisitsTheNearestSetPointStandsIn) {
  test::Bench bench;
  bench.plateaus_c = {-20, 0, 23, 46, 23, 0, -20};
  const RunAtReference reference = reference_of(run_of(bench));
  EXPECT_FALSE(reference.at_both_ends);
  EXPECT_EQ(reference.visits, (std::vector<std::int32_t>{2, 4}));
  const SensorReference& gyro = reference.sensor[kGyro].value();
  EXPECT_FALSE(gyro.drift || gyro.first || gyro.last);
  EXPECT_EQ(gyro.temp_c, 23.0);
  EXPECT_NEAR(gyro.bias.value, 0.01 + 1e-4 * 23.0, 1e-9);
  // No other plateau within 12.5 K to take a slope from.
  EXPECT_FALSE(gyro.slope_per_k);
}

TEST(ReferencePlateau, ARunThatStaysAwayHasNone) {
  test::Bench bench;
  bench.plateaus_c = {-20, 0, 22.4, 27.6, 40, -20};
  const RunAtReference reference = reference_of(run_of(bench));
  EXPECT_FALSE(reference.at_both_ends);
  EXPECT_TRUE(reference.visits.empty());
  EXPECT_TRUE(std::ranges::none_of(reference.sensor, [](const auto& sensor) { return sensor.has_value(); }));
  RunInput empty;
  EXPECT_TRUE(reference_of(empty).visits.empty());
}

TEST(ReferencePlateau, PlateausThatWereFoundInTheTemperatureCountToo) {
  RunInput run = run_of(bench_with_references());
  for (Segment& segment : run.segments) {
    if (segment.key.visit == 0) segment.plateau_c = 24.9;
    if (segment.key.visit == 5) segment.plateau_c = 25.6;
  }
  EXPECT_TRUE(reference_of(run).at_both_ends);
  for (Segment& segment : run.segments) {
    if (segment.key.visit == 5) segment.plateau_c = 26.0;  // 1.1 K from the first
  }
  EXPECT_FALSE(reference_of(run).at_both_ends);
}

TEST(ReferencePlateau, TwoVisitsWithNothingBetweenAreNoEnds) {
  test::Bench bench;
  bench.plateaus_c = {25, 24.5, 25};
  EXPECT_FALSE(reference_of(run_of(bench)).at_both_ends);
  bench.plateaus_c = {25, 25};
  EXPECT_FALSE(reference_of(run_of(bench)).at_both_ends);
}

TEST(ReferencePlateau, OrderIsThatOfTimeNotOfTheList) {
  RunInput run = run_of(bench_with_references());
  shift(run, 5, kGyro, 2e-4);
  std::ranges::reverse(run.segments);
  const RunAtReference reference = reference_of(run);
  ASSERT_TRUE(reference.at_both_ends);
  EXPECT_NEAR(reference.sensor[kGyro]->drift->value, 2e-4, 1e-12);
}

TEST(ReferencePlateau, AVoidFirstVisitLeavesARunWithoutDrift) {
  RunInput run = run_of(bench_with_references());
  std::erase_if(run.segments, [](const Segment& segment) { return segment.key.visit == 0; });
  const RunAtReference reference = reference_of(run);
  EXPECT_FALSE(reference.at_both_ends);
  EXPECT_EQ(reference.visits, (std::vector<std::int32_t>{3, 5}));
}

TEST(ReferencePlateau, ASensorThatTheDataGateRejectsAtOneEndHasTheOtherEndOnly) {
  RunInput run = run_of(bench_with_references());
  for (Segment& segment : run.segments) {
    if (segment.key.visit != 0) continue;
    segment.sensor[kGyro].mean = 5.0;
    segment.findings.push_back({"saturated", Severity::reject, Sensor::gyro_x, "pinned"});
  }
  const RunAtReference reference = reference_of(run);
  EXPECT_TRUE(reference.at_both_ends);
  const SensorReference& gyro = reference.sensor[kGyro].value();
  EXPECT_FALSE(gyro.first || gyro.drift);
  EXPECT_NEAR(gyro.bias.value, 0.01 + 1e-4 * 25.0, 1e-9);
  EXPECT_TRUE(reference.sensor[kAccel]->drift);
}

TEST(ReferencePlateau, ABiasIsCarriedAlongItsSlopeAndWithoutOneHalfAKelvinAtMost) {
  SensorReference reference;
  reference.bias = {0.5, 0.01};
  reference.temp_c = 24.0;
  EXPECT_EQ(carried_to(reference, 24.5)->value, 0.5);
  EXPECT_FALSE(carried_to(reference, 24.6));
  reference.slope_per_k = -0.2;
  EXPECT_NEAR(carried_to(reference, 26.0)->value, 0.1, 1e-12);
  EXPECT_EQ(carried_to(reference, 26.0)->standard_error, 0.01);
}

}  // namespace
}  // namespace soak::calib
