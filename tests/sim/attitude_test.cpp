// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/unit/attitude.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string_view>

#include "base/units.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;

calib::Position position(std::string_view label) { return calib::position_named(label).value_or(calib::Position{}); }

double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

TEST(Attitude, FeelsTheVerticalAndTheWholeRotationOfTheEarthInEveryPosition) {
  const double latitude_deg = -33.9;
  for (const auto label : calib::kSixPositionLabels) {
    const Attitude attitude = resting(position(label), EarthFrame{latitude_deg, 77.0});
    EXPECT_NEAR(dot(attitude.rate_rps, attitude.up), 7.292115e-5 * std::sin(latitude_deg * base::kRadPerDeg), 1e-15);
    EXPECT_NEAR(std::sqrt(dot(attitude.rate_rps, attitude.rate_rps)), 7.292115e-5, 1e-15);
  }
}

TEST(Attitude, MeasuresAzimuthClockwiseFromNorth) {
  // On the equator the rotation vector points north. Level, x pointing east: y points north. Upside down: y points
  // south.
  const Attitude level = resting(position("+Z"), EarthFrame{0.0, 90.0});
  EXPECT_NEAR(level.rate_rps[1], base::kEarthRate_rps, 1e-15);
  const Attitude inverted = resting(position("-Z"), EarthFrame{0.0, 90.0});
  EXPECT_NEAR(inverted.rate_rps[1], -base::kEarthRate_rps, 1e-15);
  const Attitude on_side = resting(position("+X"), EarthFrame{0.0, 0.0});
  EXPECT_NEAR(on_side.rate_rps[1], base::kEarthRate_rps, 1e-15);
}

TEST(Attitude, StandsStillWithoutAnEarthFrame) {
  EXPECT_EQ(resting(position("-Y"), std::nullopt).rate_rps, (Vector3{}));
}

// The up vector is fixed in space, so that in body axes d(up)/dt = up × rate.
TEST(Attitude, TurnsFromOnePositionToTheOtherAtTheRateThatItReports) {
  const double duration_s = 6.0;
  for (const auto from_label : calib::kSixPositionLabels) {
    for (const auto to_label : calib::kSixPositionLabels) {
      if (from_label == to_label) continue;
      const auto from = position(from_label);
      const auto to = position(to_label);
      const double step = 1e-6;
      const Attitude middle = turning(from, to, 0.4, duration_s);
      const Attitude before = turning(from, to, 0.4 - step, duration_s);
      const Attitude after = turning(from, to, 0.4 + step, duration_s);
      const Attitude end = turning(from, to, 1.0, duration_s);
      const Vector3 expected = cross(middle.up, middle.rate_rps);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR((after.up[axis] - before.up[axis]) / (2 * step * duration_s), expected[axis], 1e-8);
        EXPECT_NEAR(end.up[axis], to.up[axis], 1e-12) << from_label << to_label;
      }
      const double angle = from_label[1] == to_label[1] ? std::numbers::pi : std::numbers::pi / 2;
      EXPECT_NEAR(std::sqrt(dot(middle.rate_rps, middle.rate_rps)), angle / duration_s, 1e-12);
    }
  }
}

}  // namespace
}  // namespace soak::hal::sim
