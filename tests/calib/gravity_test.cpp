// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/site.h"

#include <gtest/gtest.h>

namespace soak::calib {
namespace {

TEST(Gravity, IsTheStandardValueWhereNothingIsKnown) {
  const Gravity g = gravity_at({});
  EXPECT_EQ(g.mps2, 9.80665);
  EXPECT_TRUE(g.assumed);
}

TEST(Gravity, IsTheGivenValueBeforeAnyFormula) {
  const Gravity g = gravity_at({.latitude_deg = 51.0, .height_m = 1000.0, .azimuth_deg = {}, .gravity_mps2 = 9.7});
  EXPECT_EQ(g.mps2, 9.7);
  EXPECT_FALSE(g.assumed);
}

TEST(Gravity, MatchesWgs84AtEquatorPoleAnd45Degrees) {
  // NIMA TR8350.2: 9.7803253359 at the equator, 9.8321849378 at the poles; Moritz 2000 gives 9.806199203 at 45° for GRS
  // 80, whose equatorial value is 1.44e-6 above that of WGS 84.
  EXPECT_NEAR(gravity_at({.latitude_deg = 0.0}).mps2, 9.7803253359, 1e-9);
  EXPECT_NEAR(gravity_at({.latitude_deg = -90.0}).mps2, 9.8321849378, 1e-8);
  EXPECT_NEAR(gravity_at({.latitude_deg = 45.0}).mps2, 9.806199203 - 1.44e-6, 2e-7);
}

TEST(Gravity, FallsWithHeightByTheFreeAirGradient) {
  const double low = gravity_at({.latitude_deg = 45.0, .height_m = 0.0}).mps2;
  const double high = gravity_at({.latitude_deg = 45.0, .height_m = 1000.0}).mps2;
  EXPECT_NEAR((low - high) / 1000.0, 3.086e-6, 0.005e-6);
}

TEST(EarthRate, ChangesSignWithTheHemisphere) {
  EXPECT_NEAR(vertical_earth_rate_rps(90.0), 7.292115e-5, 1e-15);
  EXPECT_NEAR(vertical_earth_rate_rps(-30.0), -0.5 * 7.292115e-5, 1e-15);
}

}  // namespace
}  // namespace soak::calib
