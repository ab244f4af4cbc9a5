// SPDX-License-Identifier: Apache-2.0
// Which thermometer the rows of a fit are over.
#include <gtest/gtest.h>

#include "base/units.h"
#include "calib/estimate/unit_rows.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

/// Six positions at three plateaus; gyro_x reads its own thermometer, `apart_c` from the unit's.
RunInput make_run(const std::string& label, double apart_c) {
  RunInput run;
  run.run_id = run.label = label;
  run.campaign = "c";
  run.site.gravity_mps2 = base::kStandardGravity_mps2;
  double t_s = 0.0;
  for (int visit = 0; visit < 3; ++visit) {
    for (const auto name : kSixPositionLabels) {
      Segment s;
      s.key = {run.run_id, "U", visit, std::string(name), 0};
      s.plateau_c = 20.0 * visit;
      s.position = *position_named(name);
      s.t_start_s = t_s;
      s.t_end_s = t_s += 600.0;
      s.temp_c = *s.plateau_c + 1e-5 * t_s;
      s.sensor_temp_c.fill(s.temp_c);
      s.sensor_temp_c[0] += apart_c;
      for (const Sensor sensor : kSensors) {
        const double f = is_gyro(sensor) ? 0.0 : base::kStandardGravity_mps2 * s.position->up[axis_of(sensor)];
        s.sensor[index_of(sensor)] = {600, f + 1e-6 * t_s, 1e-6, 1e-5};
      }
      run.segments.push_back(s);
    }
  }
  run.own_thermometer = own_thermometers(run.segments);
  return run;
}

UnitInput of_runs(std::vector<RunInput> runs) {
  UnitInput input;
  input.unit = "U";
  input.runs = std::move(runs);
  return input;
}

TEST(OwnThermometer, IsSeenInTheSegmentsOfARun) {
  EXPECT_EQ(make_run("a", 0.0).own_thermometer, (std::array<bool, kSensorCount>{}));
  EXPECT_EQ(make_run("a", 1e-9).own_thermometer[0], true);
  RunInput silent = make_run("a", 8.0);
  for (Segment& segment : silent.segments) segment.sensor[0].count = 0;
  EXPECT_FALSE(own_thermometers(silent.segments)[0]) << "a thermometer of a sensor without values is nobody's";
}

TEST(OwnThermometer, IsStatedOfTheRows) {
  const auto rows = make_rows(of_runs({make_run("a", 8.0), make_run("b", 8.0)}));
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ(rows->own_thermometer, (std::array<bool, kSensorCount>{true}));
  EXPECT_NEAR(rows->bias[0]->rows[0].temp_c, rows->bias[1]->rows[0].temp_c + 8.0, 1e-9);
}

TEST(OwnThermometer, ThatOnlySomeRunsHaveIsRefused) {
  const auto rows = make_rows(of_runs({make_run("a", 0.0), make_run("b", 8.0)}));
  EXPECT_TRUE(is_bad_input(rows, {"run b", "run a", "gyro_x"}));
  RunInput without = make_run("a", 0.0);
  for (Segment& segment : without.segments) segment.sensor[0].count = 0;
  EXPECT_TRUE(make_rows(of_runs({without, make_run("b", 8.0)}))) << "a run without the sensor may have any thermometer";
}

}  // namespace
}  // namespace soak::calib
