// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/parts_of_run.h"

#include <gtest/gtest.h>

// What one part of a run shows and the other does not (tests/cli/test_cut_short_run.py has whole fits).
namespace soak::calib {
namespace {

/// An estimate whose accelerometers have their scale error at the first so many temperatures only.
SixPositionEstimate part_with_scale_at(const std::vector<double>& temps_c, std::size_t with_scale) {
  SixPositionEstimate estimate;
  for (SensorEstimate& sensor : estimate.sensor) {
    for (std::size_t i = 0; i < temps_c.size(); ++i) {
      PlateauEstimate& plateau = sensor.plateaus.emplace_back();
      plateau.temp_c = temps_c[i];
      if (i < with_scale) plateau.scale_ppm = 100.0;
    }
    sensor.coupling.fill(0.0);
    sensor.even_order = Estimate{};
  }
  return estimate;
}

TEST(PartsOfRun, AreKnownByTheNumberBehindTheirLabel) {
  EXPECT_EQ(run_of_part("week-1/R02.2"), "week-1/R02");
  EXPECT_EQ(run_of_part("week-1/R02"), "week-1/R02");
  EXPECT_EQ(run_of_part("v1.x"), "v1.x");
  EXPECT_EQ(run_of_part("R02."), "R02.");
}

TEST(PartsOfRun, ShowEachOthersScaleErrorsAtTheSameTemperature) {
  const std::vector<SixPositionEstimate> estimates = {part_with_scale_at({0.0, 20.0}, 1),
                                                      part_with_scale_at({20.4, 40.0}, 2)};
  EXPECT_TRUE(shown_by_other_parts({"c/R1", "c/R1.2"}, estimates, 0, Sensor::accel_x));
  EXPECT_FALSE(shown_by_other_parts({"c/R1", "c/R2"}, estimates, 0, Sensor::accel_x)) << "another run is no part";
}

TEST(PartsOfRun, AreNoneWhereNoRunHasTheNameWithoutNumber) {
  std::vector<SixPositionEstimate> estimates = {part_with_scale_at({20.0}, 0), part_with_scale_at({20.0}, 1)};
  EXPECT_FALSE(shown_by_other_parts({"day.1", "day.2"}, estimates, 0, Sensor::accel_x)) << "two runs with such names";
  estimates.push_back(part_with_scale_at({20.0}, 0));
  EXPECT_TRUE(shown_by_other_parts({"day.1", "day.2", "day"}, estimates, 0, Sensor::accel_x));
}

TEST(PartsOfRun, DoNotShowWhatNoneOfThemHas) {
  std::vector<SixPositionEstimate> estimates = {part_with_scale_at({0.0, 20.0}, 1), part_with_scale_at({30.0}, 1)};
  EXPECT_FALSE(shown_by_other_parts({"R1", "R1.2"}, estimates, 0, Sensor::accel_x)) << "not at 20 °C";
  estimates[1] = part_with_scale_at({20.0}, 1);
  for (SixPositionEstimate& estimate : estimates) estimate.sensor[index_of(Sensor::gyro_y)].coupling[2].reset();
  EXPECT_TRUE(shown_by_other_parts({"R1", "R1.2"}, estimates, 0, Sensor::accel_x));
  EXPECT_FALSE(shown_by_other_parts({"R1", "R1.2"}, estimates, 0, Sensor::gyro_y)) << "its coupling to z";
}

}  // namespace
}  // namespace soak::calib
