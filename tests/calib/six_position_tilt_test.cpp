// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.h"
#include "calib/estimate/six_position.h"
#include "tests/calib/campaign_simulation.h"

namespace soak::calib {
namespace {

/// Tilted faces read g·ε where they are horizontal, in the same order in every visit, which looks like a drift.
TEST(SixPositionTilt, HorizontalFacesThatAreNotSquareDoNotReachTheLevelOfTheBias) {
  simulated::Scatter scatter;
  scatter.face_tilt_rad = 0.1 * std::numbers::pi / 180.0;
  scatter.gravity_mps2 = scatter.thermometer_c = 0.0;
  scatter.accel_run_mps2 = scatter.accel_visit_mps2 = scatter.accel_half_gap_mps2 = scatter.accel_per_v = 0.0;
  scatter.accel_noise_mps2 = 1e-4;
  base::Random random(3);
  double squares = 0.0;
  double count = 0.0;
  for (int i = 0; i < 10; ++i) {
    const auto truth = simulated::Truth::draw(random);
    const UnitInput input = simulated::campaign(truth, Sensor::gyro_y, 1, scatter, random);
    const auto estimate = estimate_six_positions(input.runs[0].segments, input.runs[0].site, input.type);
    for (const PlateauEstimate& plateau : estimate.sensor[index_of(Sensor::accel_y)].plateaus) {
      squares += std::pow(plateau.bias - truth.accel_bias.at(plateau.temp_c), 2);
      ++count;
    }
  }
  // Noise of a pair 7e-5, tilts in the second order 2e-5, carrying segments of 0.02 K along the slope's chord 1e-4;
  // in the first order they are 17e-3.
  EXPECT_LT(std::sqrt(squares / count), 5e-4);
}

}  // namespace
}  // namespace soak::calib
