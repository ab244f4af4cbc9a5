// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/model/unit_model.h"
#include "six_position_samples.h"
#include "tests/errors.h"

// Gyro scale factor from positions in which the fixture turns.
namespace soak::calib {
namespace {

using test::Bench;
using test::Stop;

/// Six faces at rest, and ±rate about each axis up.
std::vector<Stop> with_rates(double rate_dps) {
  std::vector<Stop> stops = Bench{}.stops;
  for (const char* face : {"+X", "+Y", "+Z"}) {
    stops.push_back({face, rate_dps});
    stops.push_back({face, -rate_dps});
  }
  return stops;
}

TEST(SixPositionRate, RecoversNoiseFreeScaleAndLeavesBiasAndGSensitivityAlone) {
  Bench bench;
  bench.stops = with_rates(100.0);
  const auto e = test::estimate(bench);
  for (std::size_t s = 0; s < 3; ++s) {
    ASSERT_EQ(e.sensor[s].plateaus.size(), 5U);
    for (const PlateauEstimate& p : e.sensor[s].plateaus) {
      ASSERT_TRUE(p.scale_ppm);
      EXPECT_NEAR(*p.scale_ppm, bench.gyro_scale_ppm(p.temp_c), 1e-6);
      EXPECT_NEAR(p.bias, bench.gyro_bias(p.temp_c), 1e-12);
    }
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(*e.sensor[s].coupling[j], bench.gyro_coupling[j], 1e-12);
  }
}

TEST(SixPositionRate, AtRestThereIsNoScale) {
  const auto e = test::estimate({});
  for (std::size_t s = 0; s < 3; ++s) {
    for (const PlateauEstimate& p : e.sensor[s].plateaus) EXPECT_FALSE(p.scale_ppm);
  }
  EXPECT_TRUE(e.warnings.empty());
}

TEST(SixPositionRate, OneSenseInEveryPositionShowsNoScaleEither) {
  // No position is at rest: the horizontal ones say nothing of the gyro, and g-sensitivity has no constants beside it.
  Bench bench;
  bench.stops = {{"+X", 30.0}, {"-X", 30.0}, {"+Y", 30.0}, {"-Y", 30.0}, {"+Z", 30.0}, {"-Z", 30.0}};
  const auto e = test::estimate(bench);
  for (std::size_t s = 0; s < 3; ++s) {
    for (const PlateauEstimate& p : e.sensor[s].plateaus) {
      EXPECT_FALSE(p.scale_ppm);
      EXPECT_NEAR(p.bias, bench.gyro_bias(p.temp_c), 1e-12);
    }
  }
}

TEST(SixPositionRate, IsHalfTheDifferenceOfAPairOfRates) {
  // One plateau, one pair: S = (y(+ω) − y(−ω))/(2 ω) − 1, whatever the noise. The joint fit
  // gives the drift between the two, ten minutes apart, a share of what they differ by: no more than the noise of 41
  // ppm (1e-4/(√2·1.745)) half again.
  Bench bench;
  bench.plateaus_c = {20.0};
  bench.stops = {{"+X"}, {"-X"}, {"+X", 100.0}, {"+X", -100.0}};
  bench.gyro_noise = 1e-4;
  const auto segments = test::segments_of(bench);
  const auto e = estimate_six_positions(segments, test::standard_site(), {});
  const double rate_rps = 100.0 * base::kRadPerDeg;
  const double by_hand = (segments[2].sensor[0].mean - segments[3].sensor[0].mean) / (2.0 * rate_rps) - 1.0;
  ASSERT_TRUE(e.sensor[0].plateaus.at(0).scale_ppm);
  EXPECT_NEAR(*e.sensor[0].plateaus[0].scale_ppm, 1e6 * by_hand, 60.0);
  EXPECT_NEAR(1e6 * by_hand, bench.gyro_scale_ppm(20.0), 4.0 * 41.0);
}

TEST(SixPositionRate, OneRateAndRestInTheSamePositionSuffice) {
  Bench bench;
  bench.stops.push_back({"-Z", 50.0});
  const auto e = test::estimate(bench);
  EXPECT_FALSE(e.sensor[0].plateaus[0].scale_ppm);
  EXPECT_FALSE(e.sensor[1].plateaus[0].scale_ppm);
  ASSERT_TRUE(e.sensor[2].plateaus[0].scale_ppm);
  EXPECT_NEAR(*e.sensor[2].plateaus[0].scale_ppm, bench.gyro_scale_ppm(-20.0), 1e-6);
}

TEST(SixPositionRate, ALoneRateIsNotTakenForBias) {
  // Turning about +X in the last plateau only, which has no other segment in which the x axis could tell its bias.
  Bench bench;
  auto segments = test::segments_of(bench);
  Bench turning = bench;
  turning.stops = {{"+X", 100.0}};
  turning.plateaus_c = {30.0};
  auto last = test::segments_of(turning);
  last[0].key.visit = 5;
  segments.push_back(last[0]);
  const auto e = estimate_six_positions(segments, test::standard_site(), {});
  EXPECT_EQ(e.sensor[0].plateaus.size(), 5U);
  for (const PlateauEstimate& p : e.sensor[0].plateaus) EXPECT_NEAR(p.bias, bench.gyro_bias(p.temp_c), 1e-12);
}

TEST(SixPositionRate, OneSenseInOppositePositionsIsGSensitivityToo) {
  // +ω with +X up and with −X up: y = b ± (S ω + G g) does not tell S from G.
  Bench bench;
  bench.stops = {{"+X", 100.0}, {"-X", 100.0}, {"+Y"}, {"-Y"}, {"+Z"}, {"-Z"}};
  const auto e = test::estimate(bench);
  for (const PlateauEstimate& p : e.sensor[0].plateaus) {
    EXPECT_FALSE(p.scale_ppm);
    EXPECT_NEAR(p.bias, bench.gyro_bias(p.temp_c), 1e-12);
  }
  EXPECT_FALSE(e.sensor[0].coupling[0]);
  EXPECT_TRUE(base::mentions(test::texts(e.warnings, "missing_position"), {"gyro_x"}));
}

TEST(SixPositionRate, AccelerometersDoNotFeelTheTurning) {
  Bench bench;
  const auto still = test::estimate(bench);
  bench.stops = with_rates(300.0);
  bench.lever_m = 0.1;
  const auto e = test::estimate(bench);
  for (std::size_t s = 3; s < 6; ++s) {
    for (std::size_t p = 0; p < 5; ++p) {
      EXPECT_NEAR(e.sensor[s].plateaus[p].bias, still.sensor[s].plateaus[p].bias, 1e-12);
      EXPECT_NEAR(*e.sensor[s].plateaus[p].scale_ppm, *still.sensor[s].plateaus[p].scale_ppm, 1e-6);
    }
  }
  EXPECT_NE(test::texts(e.warnings, "rate_positions").find("30 segments"), std::string::npos);
}

TEST(SixPositionRate, StandardErrorsAreHonest) {
  double scale_squares = 0.0;
  double bias_squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Bench bench;
    bench.plateaus_c = {-30, -20, -10, 0, 10, 20, 30, 40};
    bench.stops = with_rates(100.0);
    bench.gyro_noise = 1e-4;
    bench.seed = seed;
    const auto e = test::estimate(bench);
    for (const PlateauEstimate& p : e.sensor[seed % 3].plateaus) {
      scale_squares += std::pow((*p.scale_ppm - bench.gyro_scale_ppm(p.temp_c)) / *p.scale_se_ppm, 2);
      bias_squares += std::pow((p.bias - bench.gyro_bias(p.temp_c)) / p.bias_se, 2);
      ++count;
    }
  }
  // 480 estimates, eight of a run correlated: the ratio is known to 3-5 %; three of those.
  EXPECT_NEAR(std::sqrt(scale_squares / count), 1.0, 0.15);
  EXPECT_NEAR(std::sqrt(bias_squares / count), 1.0, 0.15);
}

TEST(SixPositionRate, GyrosGetAScaleCurve) {
  UnitInput input;
  input.unit = "U";
  for (int r = 0; r < 3; ++r) {
    Bench bench;
    bench.plateaus_c = {-30, -20, -10, 0, 10, 20, 30, 40, 50};
    bench.stops = with_rates(100.0);
    bench.gyro_noise = 2e-5;
    bench.accel_noise = 1e-3;
    bench.seed = static_cast<std::uint64_t>(40 + r);
    RunInput run;
    run.run_id = run.label = "R" + std::to_string(r);
    run.site = test::standard_site();
    run.segments = test::segments_of(bench);
    input.runs.push_back(run);
  }
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_TRUE(rows->scale[2]);
  const auto fit = fit_sensor(*rows, Sensor::gyro_z, {});
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_TRUE(fit->scale);
  // A row's standard error is 2e-5/(√2·1.745) = 8 ppm; three runs and a smooth curve bring less than that.
  for (const double t : {-30.0, -5.0, 25.0, 50.0}) {
    EXPECT_NEAR(evaluate(fit->scale->curve, t), Bench{}.gyro_scale_ppm(t), 25.0) << t;
  }
  const auto of_rates = [](const Warning& warning) { return warning.code == "rate_positions"; };
  EXPECT_EQ(std::ranges::count_if(rows->warnings, of_rates), 1) << "three runs, said once";
}

}  // namespace
}  // namespace soak::calib
