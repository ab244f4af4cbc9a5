// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/six_position.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "six_position_samples.h"

namespace soak::calib {
namespace {

/// A unit's truth at a temperature, and the fixture's place on Earth; readings follow the design's sign rule.
struct TrueUnit {
  std::function<double(double)> gyro_bias = [](double) { return 0.01; };
  std::function<double(double)> accel_bias = [](double) { return 0.05; };
  std::function<double(double)> scale_ppm = [](double t) { return 2000.0 + 30.0 * t; };
  Vector3 accel_row = {0.0, 0.002, -0.003};    ///< misalignment of accel_x
  Vector3 gyro_row = {3e-5, -2e-5, 4e-5};      ///< g-sensitivity of gyro_x, (rad/s)/(m/s²)
  Vector3 earth_horizontal = {0.0, 0.0, 0.0};  ///< added to gyro_x by position label index, see below
  double vertical_rate_rps = 0.0;
  double drift_per_hour =
      0.0;  ///< of the gyro within a plateau, rad/s per hour; its sign alternates from plateau to plateau
  int sign_at_rest = 1;
};

struct Options {
  std::vector<std::string> positions{kSixPositionLabels.begin(), kSixPositionLabels.end()};
  std::vector<double> plateaus = {-20, -10, 0, 10, 20};
  double gyro_noise = 0.0;
  double accel_noise = 0.0;
  double wander_c = 0.0;  ///< temperature offset from position to position
  std::uint64_t seed = 1;
};

/// Segments of one run, positions ten minutes apart; noise is that of the segment means.
std::vector<Segment> make_segments(const TrueUnit& truth, const Options& options) {
  std::vector<Segment> segments;
  base::Random random(options.seed);
  double t_s = 0.0;
  for (std::size_t p = 0; p < options.plateaus.size(); ++p) {
    int order = 0;
    for (const std::string& label : options.positions) {
      Segment s;
      s.key = {"run", "U", static_cast<std::int32_t>(p), label, 0};
      s.plateau_c = options.plateaus[p];
      s.sweep = Sweep::up;
      s.position = *position_named(label);
      s.t_start_s = t_s;
      s.t_end_s = t_s + 590.0;
      s.temp_c = options.plateaus[p] + options.wander_c * (order % 3 - 1);
      s.sensor_temp_c.fill(s.temp_c);
      const Vector3& up = s.position->up;
      const double f = base::kStandardGravity_mps2 * up[0];
      double accel = truth.accel_bias(s.temp_c) + truth.sign_at_rest * ((1 + truth.scale_ppm(s.temp_c) * 1e-6) * f);
      double gyro = truth.gyro_bias(s.temp_c) + truth.vertical_rate_rps * up[0] +
                    (p % 2 == 0 ? 1.0 : -1.0) * truth.drift_per_hour * (600.0 * (order - 2.5)) / 3600.0;
      for (std::size_t j = 0; j < 3; ++j) {
        accel += truth.sign_at_rest * truth.accel_row[j] * base::kStandardGravity_mps2 * up[j];
        gyro += truth.gyro_row[j] * base::kStandardGravity_mps2 * up[j];
      }
      // A fixture at rest on its faces: the horizontal part of the Earth's rate differs from face to face.
      if (up[0] == 0.0) gyro += truth.earth_horizontal[static_cast<std::size_t>(order) % 3];
      s.sensor[0] = {600, gyro + options.gyro_noise * random.gaussian(), 600 * options.gyro_noise * options.gyro_noise,
                     options.gyro_noise};
      s.sensor[3] = {600, accel + options.accel_noise * random.gaussian(),
                     600 * options.accel_noise * options.accel_noise, options.accel_noise};
      segments.push_back(s);
      t_s += 600.0;
      ++order;
    }
    t_s += 1800.0;
  }
  return segments;
}

const SensorEstimate& gyro_of(const SixPositionEstimate& e) { return e.sensor[0]; }
const SensorEstimate& accel_of(const SixPositionEstimate& e) { return e.sensor[3]; }
Site standard_site() {
  return {.latitude_deg = {}, .height_m = {}, .azimuth_deg = {}, .gravity_mps2 = base::kStandardGravity_mps2};
}

TEST(SixPosition, RecoversNoiseFreeTruthExactly) {
  TrueUnit truth;
  truth.gyro_bias = [](double t) { return 1e-3 * t; };
  truth.accel_bias = [](double t) { return 0.1 - 2e-3 * t; };
  const auto e = estimate_six_positions(make_segments(truth, {}), standard_site(), {});
  ASSERT_EQ(accel_of(e).plateaus.size(), 5U);
  for (const PlateauEstimate& p : accel_of(e).plateaus) {
    EXPECT_NEAR(p.bias, truth.accel_bias(p.temp_c), 1e-12);
    EXPECT_NEAR(*p.scale_ppm, truth.scale_ppm(p.temp_c), 1e-6);
  }
  for (const PlateauEstimate& p : gyro_of(e).plateaus) {
    EXPECT_NEAR(p.bias, truth.gyro_bias(p.temp_c), 1e-12);
    EXPECT_FALSE(p.scale_ppm);
  }
  for (std::size_t j = 1; j < 3; ++j) EXPECT_NEAR(*accel_of(e).coupling[j], truth.accel_row[j], 1e-12);
  for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(*gyro_of(e).coupling[j], truth.gyro_row[j], 1e-12);
  EXPECT_TRUE(e.warnings.empty());
}

TEST(SixPosition, AgreesWithTheCorrectedUpDownFormulas) {
  // [AH05 eq. 6.7-6.8] with the signs of the design: bias = (up + down)/2, scale error = (up − down)/(2 g) − 1.
  const Options two{.positions = {"+X", "-X"}, .plateaus = {0, 10}, .gyro_noise = 0, .accel_noise = 0.01};
  const auto segments = make_segments({}, two);
  const auto e = estimate_six_positions(segments, standard_site(), {});
  const double up = segments[0].sensor[3].mean;
  const double down = segments[1].sensor[3].mean;
  EXPECT_NEAR(accel_of(e).plateaus[0].bias, 0.5 * (up + down), 1e-9);
  EXPECT_NEAR(*accel_of(e).plateaus[0].scale_ppm, 1e6 * ((up - down) / (2 * base::kStandardGravity_mps2) - 1),
              40.0);  // drift term shares a little
}

TEST(SixPosition, AUnitThatReadsMinusGAtRestGivesTheSameScale) {
  TrueUnit truth;
  truth.sign_at_rest = -1;
  UnitType type;
  type.sign_at_rest = -1;
  const auto e = estimate_six_positions(make_segments(truth, {}), standard_site(), type);
  EXPECT_NEAR(accel_of(e).plateaus[1].bias, 0.05, 1e-12);
  EXPECT_NEAR(*accel_of(e).plateaus[1].scale_ppm, truth.scale_ppm(-10.0), 1e-6);
}

TEST(SixPosition, EarthRateOfUnknownAzimuthDoesNotReachTheBias) {
  TrueUnit truth;
  truth.vertical_rate_rps = 5e-5;
  truth.earth_horizontal = {4e-5, -3e-5, 1e-5};
  const auto e = estimate_six_positions(make_segments(truth, {}), standard_site(), {});
  for (const PlateauEstimate& p : gyro_of(e).plateaus) EXPECT_NEAR(p.bias, 0.01, 1e-9);
}

TEST(SixPosition, KnownLatitudeSeparatesVerticalEarthRateFromGSensitivity) {
  TrueUnit truth;
  truth.vertical_rate_rps = base::kEarthRate_rps * std::sin(-35.0 * base::kRadPerDeg);
  Site site = standard_site();
  site.latitude_deg = -35.0;
  const auto e = estimate_six_positions(make_segments(truth, {}), site, {});
  EXPECT_NEAR(*gyro_of(e).coupling[0], truth.gyro_row[0], 1e-12);
  EXPECT_NEAR(gyro_of(e).plateaus[0].bias, 0.01, 1e-12);
}

TEST(SixPosition, CarriesSegmentsToOneTemperatureAlongTheLocalSlope) {
  TrueUnit truth;
  truth.gyro_bias = [](double t) { return 2e-3 * t; };
  Options options;
  options.wander_c = 0.2;
  const auto e = estimate_six_positions(make_segments(truth, options), standard_site(), {});
  for (const PlateauEstimate& p : gyro_of(e).plateaus) EXPECT_NEAR(p.bias, truth.gyro_bias(p.temp_c), 2e-5);
}

TEST(SixPosition, ALinearDriftInThePlateauBarelyMovesTheBias) {
  // Without the drift term the axis' own pair, first in the order, would be off by 6.7e-4.
  TrueUnit truth;
  truth.drift_per_hour = 2e-3;
  Options options;
  options.gyro_noise = 5e-5;
  options.plateaus = {-30, -25, -20, -15, -10, -5, 0, 5, 10, 15, 20, 25};
  const auto e = estimate_six_positions(make_segments(truth, options), standard_site(), {});
  for (const PlateauEstimate& p : gyro_of(e).plateaus) EXPECT_NEAR(p.bias, 0.01, 5 * p.bias_se + 5e-5);
}

TEST(SixPosition, StandardErrorsAreHonest) {
  double squares = 0.0;
  double scale_squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Options options;
    options.gyro_noise = 1e-4;
    options.accel_noise = 3e-3;
    options.plateaus = {-30, -20, -10, 0, 10, 20, 30, 40};
    options.seed = seed;
    const TrueUnit truth;
    const auto e = estimate_six_positions(make_segments(truth, options), standard_site(), {});
    for (std::size_t p = 0; p < 8; ++p) {
      const PlateauEstimate& gyro = gyro_of(e).plateaus[p];
      const PlateauEstimate& accel = accel_of(e).plateaus[p];
      squares += std::pow((gyro.bias - 0.01) / gyro.bias_se, 2);
      scale_squares += std::pow((*accel.scale_ppm - truth.scale_ppm(accel.temp_c)) / *accel.scale_se_ppm, 2);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 0.15);
  EXPECT_NEAR(std::sqrt(scale_squares / count), 1.0, 0.15);
}

TEST(SixPosition, OffAxisPositionsSharpenTheGyroBias) {
  Options options;
  options.gyro_noise = 1e-4;
  options.plateaus = {-30, -20, -10, 0, 10, 20, 30, 40, 50, 60};
  const auto e = estimate_six_positions(make_segments({}, options), standard_site(), {});
  // The axis' own pair alone would give 1e-4/√2.
  EXPECT_LT(gyro_of(e).plateaus[5].bias_se, 0.75e-4);
}

TEST(SixPosition, WithoutTheAxisOwnPairItSaysWhatStaysInTheBias) {
  Options options;
  options.positions = {"+Y", "-Y", "+Z", "-Z"};
  const auto e = estimate_six_positions(make_segments({}, options), standard_site(), {});
  EXPECT_EQ(gyro_of(e).plateaus.size(), 5U);
  ASSERT_FALSE(e.warnings.empty());
  EXPECT_EQ(e.warnings.front().code, "missing_position");
  EXPECT_FALSE(accel_of(e).plateaus.front().scale_ppm);
}

TEST(SixPosition, OneDroppedVisitOfAPositionCostsOnlyAccuracy) {
  auto segments = make_segments({}, {});
  segments.erase(segments.begin() + 12);  // +X of the third plateau
  const auto e = estimate_six_positions(segments, standard_site(), {});
  ASSERT_EQ(gyro_of(e).plateaus.size(), 5U);
  EXPECT_NEAR(gyro_of(e).plateaus[2].bias, 0.01, 1e-9);
}

TEST(SixPosition, OneAttitudeGivesTheMeanReading) {
  auto segments = make_segments({}, {.positions = {"+Z"}, .plateaus = {0, 10}, .gyro_noise = 0.0});
  for (Segment& s : segments) {
    s.position.reset();
    s.key.position.clear();
  }
  const auto e = estimate_six_positions(segments, standard_site(), {});
  ASSERT_EQ(gyro_of(e).plateaus.size(), 2U);
  EXPECT_NEAR(gyro_of(e).plateaus[0].bias, segments[0].sensor[0].mean, 1e-15);
}

TEST(SixPosition, WithoutAnyStandardErrorTheResidualsAreTheMeasure) {
  // Segments that state no uncertainty but scatter by 1e-4 rad/s and 1e-2 m/s2: a unit of 1 rad/s once stood in.
  double squares = 0.0;
  double accel_squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    test::Bench bench;
    bench.plateaus_c = {-30, -20, -10, 0, 10, 20, 30, 40};
    bench.gyro_noise = 1e-4;
    bench.accel_noise = 1e-2;
    bench.seed = seed;
    auto segments = test::segments_of(bench);
    for (Segment& segment : segments) {
      for (auto& sensor : segment.sensor) sensor.standard_error = sensor.variance = 0.0;
    }
    const auto e = estimate_six_positions(segments, test::standard_site(), {});
    for (std::size_t p = 0; p < bench.plateaus_c.size(); ++p) {
      const PlateauEstimate& gyro = e.sensor[seed % 3].plateaus[p];
      const PlateauEstimate& accel = e.sensor[3 + seed % 3].plateaus[p];
      squares += std::pow((gyro.bias - bench.gyro_bias(gyro.temp_c)) / gyro.bias_se, 2);
      accel_squares += std::pow((accel.bias - bench.accel_bias(accel.temp_c)) / accel.bias_se, 2);
      ++count;
    }
  }
  // 320 estimates, eight of a run correlated by its shared unknowns: known to 5-7 %; three of those.
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(accel_squares / count), 1.0, 0.2);
}

TEST(SixPosition, WithoutScatterAndStandardErrorsTheUncertaintyIsNotKnown) {
  // 0 means not known (CurveRow::standard_error), never "half a radian per second".
  const auto e = test::estimate({});
  for (const Sensor sensor : kSensors) {
    for (const PlateauEstimate& p : e.sensor[index_of(sensor)].plateaus) EXPECT_LT(p.bias_se, 1e-9);
  }
}

}  // namespace
}  // namespace soak::calib
