// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calib/model/unit_model.h"
#include "six_position_samples.h"

// Even-order term of the accelerometers, and which bias the estimate states.
namespace soak::calib {
namespace {

using test::Bench;
using test::kGravity_mps2;

constexpr double kEven = 3e-4 / kGravity_mps2;  ///< 300 µg/g²

TEST(SixPositionEvenOrder, RecoversNoiseFreeTruth) {
  Bench bench;
  bench.even_order = kEven;
  const auto e = test::estimate(bench);
  for (std::size_t s = 3; s < 6; ++s) {
    ASSERT_TRUE(e.sensor[s].even_order);
    EXPECT_NEAR(e.sensor[s].even_order->value, kEven, 1e-12);
    for (const PlateauEstimate& p : e.sensor[s].plateaus) {
      EXPECT_NEAR(*p.scale_ppm, bench.accel_scale_ppm(p.temp_c), 1e-6);
    }
  }
  EXPECT_TRUE(e.warnings.empty());
}

TEST(SixPositionEvenOrder, BiasIsThatOfUpAndDownAndTheTermLeadsToThatAtZeroG) {
  Bench bench;
  bench.even_order = kEven;
  const auto segments = test::segments_of(bench);
  const auto e = estimate_six_positions(segments, test::standard_site(), {});
  const PlateauEstimate& first = e.sensor[3].plateaus[0];
  // [AH05 eq. 6.7, sign corrected]
  EXPECT_NEAR(first.bias, 0.5 * (segments[0].sensor[3].mean + segments[1].sensor[3].mean), 1e-12);
  const double at_0_g = first.bias - e.sensor[3].even_order->value * kGravity_mps2 * kGravity_mps2;
  EXPECT_NEAR(at_0_g, bench.accel_bias(first.temp_c), 1e-12);
}

TEST(SixPositionEvenOrder, AUnitThatReadsMinusGAtRestHasTheSameTerm) {
  Bench bench;
  bench.even_order = kEven;
  auto segments = test::segments_of(bench);
  // Readings of a unit that senses −f: bias and even order as they were, all odd parts reversed.
  for (Segment& segment : segments) {
    for (std::size_t s = 3; s < 6; ++s) {
      Vector3 down = segment.position->up;
      for (double& component : down) component = -component;
      segment.sensor[s].mean = test::accel_reading(bench, segment.temp_c, s - 3, down, 0.0);
    }
  }
  UnitType type;
  type.sign_at_rest = -1;
  const auto e = estimate_six_positions(segments, test::standard_site(), type);
  EXPECT_NEAR(e.sensor[4].even_order->value, kEven, 1e-12);
  EXPECT_NEAR(*e.sensor[4].plateaus[0].scale_ppm, bench.accel_scale_ppm(-20.0), 1e-6);
}

TEST(SixPositionEvenOrder, TiltedSideFacesDoNotReachTheBias) {
  // Faces 0.1 degree off the horizontal, all to one side: 17 mm/s² in the horizontal readings.
  Bench bench;
  auto segments = test::segments_of(bench);
  const double lean = kGravity_mps2 * std::sin(0.1 * base::kRadPerDeg);
  for (Segment& segment : segments) {
    for (std::size_t s = 3; s < 6; ++s) {
      if (segment.position->up[s - 3] == 0.0) segment.sensor[s].mean += lean;
    }
  }
  const auto e = estimate_six_positions(segments, test::standard_site(), {});
  for (const PlateauEstimate& p : e.sensor[5].plateaus) EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c), 1e-12);
  EXPECT_NEAR(e.sensor[5].even_order->value, -lean / (kGravity_mps2 * kGravity_mps2), 1e-12);
}

TEST(SixPositionEvenOrder, StandardErrorsAreHonest) {
  double even = 0.0;
  double coupling = 0.0;
  double bias = 0.0;
  int runs = 0;
  int rows = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    Bench bench;
    bench.even_order = kEven;
    bench.accel_noise = 1e-3;
    bench.seed = seed;
    const auto e = test::estimate(bench);
    for (std::size_t s = 3; s < 6; ++s, ++runs) {
      const SensorEstimate& sensor = e.sensor[s];
      even += std::pow((sensor.even_order->value - kEven) / sensor.even_order->standard_error, 2);
      const std::size_t across = (s - 3 + 1) % 3;
      coupling += std::pow((*sensor.coupling[across] - bench.accel_coupling[across]) / sensor.coupling_se[across], 2);
      for (const PlateauEstimate& p : sensor.plateaus) {
        const double truth = bench.accel_bias(p.temp_c) + kEven * kGravity_mps2 * kGravity_mps2;
        bias += std::pow((p.bias - truth) / p.bias_se, 2);
        ++rows;
      }
    }
  }
  // 450 independent values: the ratio is known to 3.3 %, the errors (inflated at times) err to the safe side.
  EXPECT_NEAR(std::sqrt(even / runs), 1.0, 0.15);
  EXPECT_NEAR(std::sqrt(coupling / runs), 1.0, 0.15);
  EXPECT_NEAR(std::sqrt(bias / rows), 1.0, 0.15);
}

UnitInput unit_with(double even_order) {
  UnitInput input;
  input.unit = "U";
  for (int r = 0; r < 3; ++r) {
    Bench bench;
    bench.even_order = even_order;
    bench.gyro_noise = 2e-5;
    bench.accel_noise = 1e-3;
    bench.seed = static_cast<std::uint64_t>(r + 1);
    RunInput run;
    run.run_id = run.label = "R" + std::to_string(r);
    run.site = test::standard_site();
    run.segments = test::segments_of(bench);
    input.runs.push_back(run);
  }
  return input;
}

TEST(SixPositionEvenOrder, AUnitIsToldOfASignificantTerm) {
  const auto rows = make_rows(unit_with(kEven));
  ASSERT_TRUE(rows);
  const std::string text = test::texts(rows->warnings, "even_order");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
  const std::string start = "accel_y: even-order term of ";
  const std::size_t at = text.find(start);
  ASSERT_NE(at, std::string::npos) << text;
  // One run: (up + down)/2 less the mean of four, 1e-3·√(1/2 + 1/4)/√5 plateaus, in µg 39; three runs 23.
  EXPECT_NEAR(std::stod(text.substr(at + start.size())), 300.0, 4.0 * 23.0);
  EXPECT_NE(text.find("m/s2 lower"), std::string::npos) << text;
}

TEST(SixPositionEvenOrder, AUnitWithoutTheTermIsToldNothing) {
  const auto rows = make_rows(unit_with(0.0));
  ASSERT_TRUE(rows);
  EXPECT_EQ(test::texts(rows->warnings, "even_order"), "");
}

}  // namespace
}  // namespace soak::calib
