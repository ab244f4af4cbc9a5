// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "calib/deploy/detail/comment.h"
#include "calib/deploy/detail/cubic_refit.h"
#include "tests/calib/export_cubic_samples.h"

namespace soak::calib {
namespace {

using namespace samples;
using exporting::Cubic;
using exporting::TempRange;

double value_of(const Cubic& c, double d) { return c[0] + d * (c[1] + d * (c[2] + d * c[3])); }

/// Σ (cubic − bias)²/u² over a grid of its own, u linear from u0 to u1 over the range.
double cost(const Cubic& c, const Curve& bias, TempRange range, double reference_c, double u0, double u1) {
  double sum = 0.0;
  for (int i = 0; i <= 2000; ++i) {
    const double share = i / 2000.0;
    const double temp_c = range.min_c + share * (range.max_c - range.min_c);
    const double u = u0 + share * (u1 - u0);
    sum += std::pow((value_of(c, temp_c - reference_c) - evaluate(bias, temp_c)) / u, 2.0);
  }
  return sum;
}

TEST(CubicRefit, NoOtherCubicHasALowerWeightedError) {
  for (const SensorCalibration& golden : golden_fis().sensors) {
    SensorCalibration sensor = golden;
    sensor.bias_uncertainty = {{-30.0, 70.0}, {1e-4, 3e-4}, {}};
    const TempRange range{-30.0, 70.0};
    const Cubic best = exporting::best_cubic(sensor, range, 35.0);
    const double least = cost(best, sensor.bias, range, 35.0, 1e-4, 3e-4);
    for (std::size_t k = 0; k < 4; ++k) {
      // A change of this coefficient by what moves the cubic by 1 % of its misfit at the far end of the range.
      const double step = 0.01 * std::sqrt(least / 2001.0) * 2e-4 / std::pow(65.0, static_cast<double>(k));
      for (const double sign : {-1.0, 1.0}) {
        Cubic other = best;
        other[k] += sign * step;
        EXPECT_GT(cost(other, sensor.bias, range, 35.0, 1e-4, 3e-4), least) << name_of(sensor.sensor) << ' ' << k;
      }
    }
  }
}

TEST(CubicRefit, LosesOfAFourthPowerWhatLegendreSays) {
  // Least squares on [-1, 1] leaves of s^4 the Legendre polynomial 8/35 P4(s): worst 8/35 at both ends (P4(±1) = 1),
  // rms 8/35 / sqrt(9) = 8/105. The even grid with its ends differs from the integral by some 1/2000 of each; the table
  // by less.
  SensorCalibration sensor =
      six_sensors(-30.0, 70.0, [](Sensor) {
        return fine_table(-30.0, 70.0, [](double t) { return std::pow((t - 20.0) / 50.0, 4.0); });
      }).sensors[3];
  const TempRange range{-30.0, 70.0};
  const Cubic best = exporting::best_cubic(sensor, range, 20.0);
  const CubicLoss loss = exporting::loss_of(sensor, range, 20.0, [&](float temp_c) {
    return static_cast<float>(value_of(best, static_cast<double>(temp_c) - 20.0));
  });
  EXPECT_NEAR(loss.rms, 8.0 / 105.0, 0.002 * 8.0 / 105.0);
  EXPECT_NEAR(loss.worst, 8.0 / 35.0, 0.005 * 8.0 / 35.0);
  EXPECT_NEAR(std::abs(loss.worst_temp_c - 20.0), 50.0, 1e-9);
}

TEST(CubicRefit, WeighsByTheSquareOfTheBandButNeverMoreThanNineTimesTheMedians) {
  const UncertaintyTable band{{0.0, 50.0, 100.0}, {0.0, 2.0, 4.0}, {}};
  const std::vector<double> temps = {0.0, 25.0, 50.0, 75.0, 100.0};  // widths 0, 1, 2, 3, 4; median 2
  const std::vector<double> weights = exporting::fit_weights(band, temps);
  EXPECT_NEAR(weights[1] / weights[4], 16.0, 1e-12);
  EXPECT_NEAR(weights[0] / weights[2], 9.0, 1e-12);
  EXPECT_EQ(exporting::fit_weights({}, temps), std::vector<double>(5, 1.0));
  EXPECT_EQ(exporting::fit_weights({{0.0, 100.0}, {0.0, 0.0}, {}}, temps), std::vector<double>(5, 1.0));
}

TEST(CubicRefit, TellsTheShareOfTheRangeBeyondTheBandAndTheSlope) {
  // Curve 0, correction 1e-3 (T - 20): beyond a band of 0.025 where |T - 20| > 25, half of -30 ... 70 °C.
  SensorCalibration sensor = six_sensors(-30.0, 70.0, [](Sensor) { return TableCurve{-30.0, 1.0, {0.0}}; }).sensors[0];
  sensor.bias_uncertainty = {{20.0}, {0.025}, {}};
  const CubicLoss loss =
      exporting::loss_of(sensor, {-30.0, 70.0}, 20.0, [](float temp_c) { return 1e-3F * (temp_c - 20.0F); });
  EXPECT_NEAR(loss.beyond_ci95, 0.5, 0.002);  // two points of 2001 lie on the border
  // Differences over 0.05 °C of float32 numbers near 0.05, spaced 4e-9.
  EXPECT_NEAR(loss.steepest_per_c, 1e-3, 1e-6);
  EXPECT_NEAR(loss.worst, 0.05, 1e-8);
  EXPECT_EQ(loss.ci95_at_worst, 0.025);
}

TEST(ExportComment, CannotBeLeft) {
  EXPECT_EQ(exporting::comment("a\nTC_A_ENABLE\t1\r\xC3\xA9"), "# a_TC_A_ENABLE_1___\n");
}

TEST(ExportComment, FixedNotationReadsBackTheSameFloat) {
  for (const float value : {0.0F, -1.5F, 1.2345678e-9F, 3.4e6F, -7.25e-5F}) {
    const std::string text = exporting::fixed_text(value);
    EXPECT_EQ(text.find('e'), std::string::npos);
    EXPECT_EQ(std::stof(text), value) << text;
  }
}

}  // namespace
}  // namespace soak::calib
