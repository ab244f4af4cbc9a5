// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/verification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/statistics.h"
#include "calib/judge/detail/row_errors.h"
#include "six_position_samples.h"
#include "tests/errors.h"

// A calibration against fresh runs: decision rule, uncertainty, and the bands that the file states.
namespace soak::calib {
namespace {

using test::Bench;
using test::Stop;
using verification::RowError;

using Function = std::function<double(double)>;

TableCurve sampled(const Function& f, double error = 0.0) {
  TableCurve curve{-40.0, 1.0, {}};
  for (int i = 0; i <= 100; ++i) curve.values.push_back(f(-40.0 + i) + error);
  return curve;
}

UncertaintyTable flat(double ci95, double pi95) {
  UncertaintyTable table{{-30.0, 40.0}, {ci95, ci95}, {}};
  if (pi95 > 0.0) table.pi95 = {pi95, pi95};
  return table;
}

/// A file that says the truth of a bench, but for constant errors of gyro bias and accelerometer scale.
Calibration true_file(const Bench& bench, double gyro_error = 0.0, double scale_error_ppm = 0.0) {
  Calibration file;
  file.unit = "U";
  file.run_hashes = {"a", "b", "c", "d"};
  for (const Sensor sensor : kSensors) {
    SensorCalibration stated;
    stated.sensor = sensor;
    stated.temp_min_c = -30.0;
    stated.temp_max_c = 40.0;
    stated.bias = is_gyro(sensor) ? sampled(bench.gyro_bias, gyro_error) : sampled(bench.accel_bias);
    stated.bias_uncertainty = flat(1e-4, 1e-3);
    if (!is_gyro(sensor)) {
      stated.scale_ppm = sampled(bench.accel_scale_ppm, scale_error_ppm);
      stated.scale_uncertainty = flat(50.0, 0.0);
    }
    file.sensors.push_back(stated);
  }
  return file;
}

/// Fresh runs between the plateaus.
Bench fresh_bench() {
  Bench bench;
  bench.plateaus_c = {-25, -15, -5, 5, 15, 25, 35};
  bench.gyro_noise = 1e-5;
  bench.accel_noise = 1e-3;
  return bench;
}

UnitInput runs_of(const Bench& bench, const Site& site = test::standard_site()) {
  UnitInput input;
  input.unit = "U";
  RunInput run;
  run.run_id = run.label = "V1";
  run.campaign = "check";
  run.content_sha256 = "fresh";
  run.site = site;
  run.segments = test::segments_of(bench);
  input.runs.push_back(run);
  return input;
}

Limits wide_limits() {
  Limits limits;
  limits.bias.fill(1.0);
  return limits;
}

TEST(Verification, PassesATrueFileAndSaysWhereAndHowWell) {
  const auto result = verify(true_file({}), runs_of(fresh_bench()), wide_limits());
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->verdict, Verdict::pass);
  const SensorVerification& gyro = *result->sensors[0];
  ASSERT_EQ(gyro.temps_c.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(gyro.temps_c[i], -25.0 + 10.0 * static_cast<double>(i), 1e-9);
  EXPECT_NEAR(gyro.covered, 60.0 / 70.0, 1e-9);
  // U is 1.96 standard errors of a row; a pair of segment means of 1e-5 each gives at most 1e-5/√2, and no less than
  // half of that with the help of the four other positions.
  EXPECT_LT(gyro.guard, 1.96 * 1.5e-5 / std::sqrt(2.0));
  EXPECT_GT(gyro.guard, 1.96 * 0.5e-5 / std::sqrt(2.0));
  EXPECT_EQ(test::texts(result->warnings, "band_too_narrow"), "");
}

TEST(Verification, ASensorWithALimitThatTheRunsDoNotGiveIsNotMeasuredAndNeverPasses) {
  UnitInput runs = runs_of(fresh_bench());
  for (Segment& segment : runs.runs[0].segments) segment.sensor[2] = {};
  const auto result = verify(true_file({}), runs, wide_limits());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->sensors[2]->verdict, Verdict::not_measured);
  EXPECT_EQ(result->sensors[2]->rows, 0U);
  EXPECT_EQ(result->verdict, Verdict::info);
  EXPECT_NE(test::texts(result->warnings, "not_verified").find("gyro_z"), std::string::npos);
}

TEST(Verification, ALimitOnASensorThatTheFileLacksIsNotMeasured) {
  Calibration file = true_file({});
  file.sensors.erase(file.sensors.begin());
  const auto result = verify(file, runs_of(fresh_bench()), wide_limits());
  ASSERT_TRUE(result);
  EXPECT_EQ(result->sensors[0]->verdict, Verdict::not_measured);
  EXPECT_EQ(result->verdict, Verdict::info);
}

TEST(Verification, HalfTheRangeIsNotMeasuredButMayFail) {
  Bench bench = fresh_bench();
  bench.plateaus_c = {-25, -15, -5, 5};
  Limits limits = wide_limits();
  auto result = verify(true_file({}), runs_of(bench), limits);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->sensors[1]->verdict, Verdict::not_measured);
  EXPECT_EQ(result->verdict, Verdict::info);
  limits[1] = 1e-3;
  result = verify(true_file({}, 2e-3), runs_of(bench), limits);
  EXPECT_EQ(result->sensors[1]->verdict, Verdict::fail);
  EXPECT_EQ(result->verdict, Verdict::fail);
}

TEST(Verification, AnErrorBeyondItsLimitPassesInFewerThanTheStatedShareOfRuns) {
  // JCGM 106 §8.3.2: true error equal to the limit at every temperature; P(pass) must be at most 2.5 %. One temperature
  // only would be the worst case: three rows close to each other, of one visit each, stand for it.
  constexpr int kTrials = 400;
  constexpr double kLimit = 1e-4;
  int passes = 0;
  int fails = 0;
  Limits limits;
  limits[0] = kLimit;
  for (int trial = 0; trial < kTrials; ++trial) {
    Bench bench = fresh_bench();
    bench.plateaus_c = {-30, 40};
    bench.seed = static_cast<std::uint64_t>(100 + trial);
    const auto result = verify(true_file({}, kLimit), runs_of(bench), limits);
    ASSERT_TRUE(result);
    passes += result->sensors[0]->verdict == Verdict::pass ? 1 : 0;
    fails += result->sensors[0]->verdict == Verdict::fail ? 1 : 0;
  }
  // Two rows: a pass needs both, 0.06 % (one in 1600); a fail one of them, 5 %. Binomial limits at 0.1 %: 3 and 36; the
  // share of fails is not 0 either: under 5 of 400 has a chance below 0.1 %.
  EXPECT_LE(passes, 3);
  EXPECT_LE(fails, 36);
  EXPECT_GE(fails, 5);
}

TEST(Verification, WhatWandersFromVisitToVisitIsPartOfTheUncertainty) {
  // Rows that state 1e-5 and scatter by 1e-4 from visit to visit, about a curve that errs smoothly by ten times that.
  base::Random random(11);
  double inside = 0.0;
  double count = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    CurveData data;
    std::vector<double> wander;
    for (int i = 0; i < 20; ++i) {
      wander.push_back(1e-4 * random.gaussian());
      CurveRow row;
      row.temp_c = -30.0 + 3.5 * i;
      row.value = 1e-3 * std::sin(row.temp_c / 25.0) + wander.back();
      row.standard_error = 1e-5;
      data.rows.push_back(row);
    }
    const auto errors = verification::errors_of(TableCurve{-40.0, 100.0, {0.0, 0.0}}, -30.0, 40.0, data);
    for (std::size_t i = 0; i < 20; ++i) {
      inside += std::abs(wander[i]) <= verification::expanded(errors.rows[i], 0.0) ? 1.0 : 0.0;
      ++count;
    }
  }
  // The median of 18 second differences that overlap is a rough estimate: 1.96 standard errors would hold 93.3 %,
  // Student's t with nine degrees of freedom holds 96.0 %, as each error is among those that the estimate comes from
  // (simulation of that alone, 20,000 times, with NumPy). The smooth error adds (3.5/25)²·1e-3 = 2e-5 to differences
  // of 2.4e-4: nothing. 200 estimates of one variance each know the share to 0.5 %; four of those.
  EXPECT_NEAR(inside / count, 0.960, 0.02);
}

TEST(Verification, GravityEntersTheUncertaintyOfScaleAndNotOfBias) {
  const Bench bench = fresh_bench();
  Site latitude = test::standard_site();
  latitude.gravity_mps2.reset();
  latitude.latitude_deg = 45.0;
  latitude.height_m = 0.0;
  Limits limits = wide_limits();
  const auto given = verify(true_file({}), runs_of(bench), limits);
  const auto normal = verify(true_file({}), runs_of(bench, latitude), limits);
  const auto assumed = verify(true_file({}), runs_of(bench, {}), limits);
  ASSERT_TRUE(given && normal && assumed);
  const auto scale_u = [](const auto& result) {
    return result->sensors[3]->scale->guard / result->sensors[3]->scale->guard_factor;
  };
  // 5e-4 m/s² of anomalies; 9.80665 for anything from 9.7803 to 9.8322, rectangular: 0.0263/√3.
  const double noise = scale_u(given);
  EXPECT_NEAR(scale_u(normal), std::hypot(noise, 5e-4 / 9.80665 * 1e6), 2.0);
  EXPECT_NEAR(scale_u(assumed), std::hypot(noise, 0.01520 / 9.80665 * 1e6), 2.0);
  EXPECT_NEAR(given->sensors[3]->guard, assumed->sensors[3]->guard, 1e-9);
}

TEST(Verification, TheGuardBandIsStudentsAtEffectiveDegreesOfFreedom) {
  // t for 95 %, two-sided, from the table of JCGM 100:2008, G.2: 2.09 at 20, 4.30 at 2, 2.57 at 5, 1.96 at infinity.
  const RowError noise{0, 25.0, 0.0, 2.0};
  EXPECT_NEAR(verification::expanded(noise, 0.0) / 2.0, 2.09, 5e-3);
  const RowError slow{0, 25.0, 0.0, 3.0, 3.0, 2.0};
  EXPECT_NEAR(verification::expanded(slow, 0.0) / 3.0, 4.30, 5e-3);
  EXPECT_NEAR(verification::expanded(RowError{0, 25.0, 0.0, 0.0}, 7.0) / 7.0, 1.96, 5e-3);
  // Welch-Satterthwaite, G.4.2: 1 of 3 degrees of freedom beside 0.727 that is known: ν = (1 + 0.727²)²·3 = 7.01, and
  // tables have whole degrees.
  const RowError three{0, 25.0, 0.0, 1.0, 1.0, 3.0};
  EXPECT_NEAR(verification::expanded(three, 0.727) / std::hypot(1.0, 0.727), 2.36, 5e-3);
  // Fewer than three count by their share of the variance, 1/(1 + 2/6·0.763²) to the fourth power.
  const RowError two{0, 25.0, 0.0, 1.0, 1.0, 2.0};
  const double share = 1.0 / (1.0 + 0.763 * 0.763 / 3.0);
  const double squared_t = 1.96 * 1.96 + (4.303 * 4.303 - 1.96 * 1.96) * std::pow(share, 4);
  EXPECT_NEAR(verification::expanded(two, 0.763), std::hypot(1.0, 0.763) * std::sqrt(squared_t), 5e-3);
  EXPECT_EQ(verification::expanded(RowError{0, 25.0, 0.0, 0.0}, 0.0), 0.0);
}

TEST(Verification, NamesWhatItsGuardBandLeavesOut) {
  UnitInput runs = runs_of(fresh_bench());
  const auto bare = verify(true_file({}), runs, wide_limits());
  ASSERT_TRUE(bare);
  using Names = std::vector<std::string>;
  EXPECT_EQ(bare->sensors[0]->not_stated, Names{"fixture"});
  EXPECT_EQ(bare->sensors[4]->not_stated, Names{"fixture"});
  EXPECT_EQ(bare->sensors[4]->scale->not_stated, (Names{"gravity", "fixture"})) << "a gravity given by hand";
  Reference cube;
  cube.kind = ReferenceKind::fixture_squareness;
  cube.standard_uncertainty = 1e-4;
  Reference gravimeter;
  gravimeter.kind = ReferenceKind::gravity;
  gravimeter.standard_uncertainty = 0.01;
  runs.references = {{cube, {}}, {gravimeter, {}}};
  const auto stated = verify(true_file({}), runs, wide_limits());
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->sensors[0]->not_stated, Names{});
  EXPECT_EQ(stated->sensors[4]->scale->not_stated, Names{});
}

TEST(Verification, AReferenceOfTheCampaignStatesGravity) {
  UnitInput runs = runs_of(fresh_bench());
  Reference gravimeter;
  gravimeter.kind = ReferenceKind::gravity;
  gravimeter.standard_uncertainty = 0.01;
  runs.references.push_back({gravimeter, {}});
  const auto result = verify(true_file({}), runs, wide_limits());
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->sensors[4]->scale->guard, 1.96 * 0.01 / 9.80665 * 1e6, 30.0);
}

TEST(Verification, ScaleHasItsOwnLimitAndDrawsTheSensorDown) {
  Limits limits = wide_limits();
  limits.scale_ppm.fill(500.0);
  const auto result = verify(true_file({}, 0.0, 2000.0), runs_of(fresh_bench()), limits);
  ASSERT_TRUE(result);
  const SensorVerification& accel = *result->sensors[5];
  EXPECT_EQ(accel.bias_verdict, Verdict::pass);
  EXPECT_EQ(accel.scale->verdict, Verdict::fail);
  EXPECT_EQ(accel.verdict, Verdict::fail);
  // A segment mean of 1e-3 m/s² is 102 ppm of g, half of that with both sides; seven rows: four of those.
  EXPECT_NEAR(accel.scale->worst_abs, 2000.0, 4.0 * 72.0);
  // Nobody can tell the scale of a gyro at rest.
  EXPECT_EQ(result->sensors[0]->scale->verdict, Verdict::not_measured);
  EXPECT_EQ(result->sensors[0]->verdict, Verdict::not_measured);
}

TEST(Verification, GyroScaleIsVerifiedWhereTheFixtureTurns) {
  Bench bench = fresh_bench();
  for (const char* face : {"+X", "+Y", "+Z"}) {
    bench.stops.push_back({face, 100.0});
    bench.stops.push_back({face, -100.0});
  }
  Calibration file = true_file(bench);
  file.sensors[0].scale_ppm = sampled(bench.gyro_scale_ppm, 300.0);
  Limits limits = wide_limits();
  limits.scale_ppm[0] = 1000.0;
  UnitInput runs = runs_of(bench);
  const auto alone = verify(file, runs, limits);
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->sensors[0]->scale->verdict, Verdict::pass);
  EXPECT_NEAR(alone->sensors[0]->scale->rmse_abs, 300.0, 15.0);
  Reference table;
  table.kind = ReferenceKind::rate;
  table.standard_uncertainty = 400.0;  // ppm of the rate: |300| + 1.96·400 is beyond the limit
  runs.references.push_back({table, {}});
  EXPECT_EQ(verify(file, runs, limits)->sensors[0]->scale->verdict, Verdict::marginal);
}

TEST(Verification, AFileThatStatesTooNarrowABandIsTold) {
  Calibration file = true_file({}, 5e-3);  // five times pi95; four runs allow 4.66 times
  const auto result = verify(file, runs_of(fresh_bench()), {});
  ASSERT_TRUE(result);
  const BandComparison& band = *result->sensors[0]->fresh_band;
  EXPECT_NEAR(band.ratio, 5.0, 0.01);
  EXPECT_EQ(band.inside, 0.0);
  // Fifteen comparisons: pi95 and ci95 of six biases, ci95 of three scales. Student's t at 3 degrees of freedom,
  // two-sided 0.01/15 (SciPy 1.10: 14.8194) and 0.05 (tables: 3.1824).
  EXPECT_NEAR(band.ratio_max, 14.8194 / 3.1824, 1e-3);
  EXPECT_FALSE(result->sensors[0]->shape_band->too_narrow()) << "a constant error is none of the shape";
  EXPECT_TRUE(base::mentions(test::texts(result->warnings, "band_too_narrow"), {"gyro_x", "5.00", "4.66"}));
}

TEST(Verification, ABumpBetweenThePlateausIsAnErrorOfTheShape) {
  Bench bench = fresh_bench();
  bench.plateaus_c = {-25, -20, -15, -10, -5, 0, 5, 10, 15, 20, 25, 30, 35};
  const Function smooth = bench.gyro_bias;
  bench.gyro_bias = [smooth](double t) { return smooth(t) + 3e-3 * std::exp(-0.5 * std::pow((t - 5.0) / 3.0, 2)); };
  const auto result = verify(true_file({}), runs_of(bench), {});
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->sensors[0]->fresh_band->too_narrow());
  EXPECT_TRUE(result->sensors[0]->shape_band->too_narrow()) << result->sensors[0]->shape_band->ratio;
}

// What is not known of the correlation of errors within a run must not raise the share of false alarms.
class BandsUnderCorrelation : public ::testing::TestWithParam<double> {};

TEST_P(BandsUnderCorrelation, ARightBandIsCalledTooNarrowOnceInAHundred) {
  const double correlation = GetParam();
  base::Random random(7);
  for (const int file_runs : {2, 4, 20}) {
    constexpr int kTrials = 8000;
    const double freedoms = file_runs - 1.0;
    int alarms = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      double squares = 0.0;  // of the file's own runs: what it estimates its band from
      for (int r = 0; r < file_runs - 1; ++r) squares += std::pow(random.gaussian(), 2);
      const double band = base::student_t_two_sided(0.95, freedoms) * std::sqrt(squares / freedoms);
      std::vector<RowError> rows;
      const double common = random.gaussian();
      for (int i = 0; i < 20; ++i) {
        const double error = std::sqrt(correlation) * common + std::sqrt(1.0 - correlation) * random.gaussian();
        rows.push_back({0, 5.0 * i, error, 0.0});
      }
      alarms += verification::compare_fresh(rows, flat(band, band), static_cast<std::size_t>(file_runs))->too_narrow();
    }
    // 1 %, and 1.25 % at most with two runs, where the estimate of the band itself comes near zero; 8000 trials know it
    // to 0.12 %: three of those.
    EXPECT_LE(alarms / static_cast<double>(kTrials), 0.0125 + 0.0037) << file_runs << " runs";
    if (correlation == 1.0) {
      EXPECT_GE(alarms / static_cast<double>(kTrials), 0.01 - 0.0034) << file_runs << " runs";
    }
  }
}

TEST(Verification, OneRightFileInAHundredIsWarnedOfHoweverManyCurvesItHas) {
  // Fifteen curves of a file, each with a band of its own from the scatter of its own runs, each off by one error
  // throughout: the worst correlation within a curve, and none between curves. 1 − (1 − 0.01/15)^15 = 0.995 %.
  constexpr std::size_t kCurves = 15;
  constexpr int kTrials = 20000;
  base::Random random(21);
  for (const int file_runs : {4, 20}) {
    const double freedoms = file_runs - 1.0;
    const double t95 = base::student_t_two_sided(0.95, freedoms);
    const double largest = verification::largest_ratio(static_cast<std::size_t>(file_runs), kCurves);
    int alarms = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      bool any = false;
      for (std::size_t c = 0; c < kCurves; ++c) {
        double squares = 0.0;
        for (int r = 0; r < file_runs - 1; ++r) squares += std::pow(random.gaussian(), 2);
        any = std::abs(random.gaussian()) > largest * t95 * std::sqrt(squares / freedoms) || any;
      }
      alarms += any ? 1 : 0;
    }
    // Three binomial standard errors of 20,000 files: 0.21 %.
    EXPECT_NEAR(alarms / static_cast<double>(kTrials), 0.00995, 0.0021) << file_runs << " runs";
  }
}

INSTANTIATE_TEST_SUITE_P(Verification, BandsUnderCorrelation, ::testing::Values(0.0, 0.3, 0.9, 1.0));

TEST(Verification, HysteresisIsScatterAboutTheMeanCurveNotAnErrorOfIt) {
  // Up and down sweep ±5e-4 about a curve of which the file claims 1e-5: the means over both are right.
  base::Random random(3);
  std::vector<RowError> rows;
  for (int i = 0; i < 10; ++i) {
    rows.push_back({0, 5.0 * i, 5e-4 + 1e-5 * random.gaussian(), 1e-5});
    rows.push_back({0, 5.0 * i + 0.3, -5e-4 + 1e-5 * random.gaussian(), 1e-5});
  }
  const auto band = verification::compare_shape(rows, flat(1e-5, 0.0), 4);
  ASSERT_TRUE(band);
  EXPECT_FALSE(band->too_narrow());
  EXPECT_EQ(verification::cells_of(rows).size(), 10U);
}

}  // namespace
}  // namespace soak::calib
