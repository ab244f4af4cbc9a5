// SPDX-License-Identifier: Apache-2.0
#include "nav/outages/outage_runner.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/units.h"
#include "nav/filter/tuning.h"
#include "nav/inertial/drift.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;

const Geodetic kOrigin{51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0};

Drive town(const UnitErrors& errors, std::uint64_t seed, const ThermalBias& thermal = {}) {
  const auto maneuvers = town_drive(240, 15, seed);
  Drive drive = Trajectory(kOrigin, 0.3, maneuvers).drive(50, 50, {0.0, 0.5, 0.5});
  drive.name = "town";
  add_errors(drive.imu, errors, {20.0, 60.0, 100.0}, thermal, seed);
  drive.gnss = simulated_fixes(drive.truth, 1, {}, seed);
  return drive;
}

Pipeline plain(SensorModels sensors = typical_mems()) {
  FilterPipeline parts{"raw", "", {}, {}, {}};
  parts.filter.sensors = sensors;
  return filter_pipeline(parts);
}

TEST(Bootstrap, TheIntervalOfAMeanIsThatOfItsStandardError) {
  base::Random random(4);
  std::vector<double> values(200);
  for (double& value : values) value = 3.0 + random.gaussian();
  const Estimate mean = bootstrap(
      values.size(),
      [&](std::span<const std::size_t> chosen) {
        double sum = 0.0;
        for (const std::size_t i : chosen) sum += values[i];
        return sum / static_cast<double>(chosen.size());
      },
      1);
  // 2·1.96/sqrt(200) of normal numbers whose scatter is known to 5 %, by percentiles known to 4 %.
  EXPECT_NEAR(mean.high - mean.low, 2.0 * 1.96 / std::sqrt(200.0), 0.15 * 0.277);
  EXPECT_LT(mean.low, mean.value);
  EXPECT_GT(mean.high, mean.value);
  EXPECT_TRUE(std::isnan(bootstrap(4, [](auto) { return 1.0; }, 1).low));
}

TEST(Outages, AreSpreadOverTheDriveAndRefusedWhereTheyDoNotFit) {
  const Drive drive = town({}, 1);
  const auto outages = spread_outages(drive, 60.0, 30.0, 4);
  ASSERT_TRUE(outages);
  ASSERT_EQ(outages->size(), 4u);
  EXPECT_NEAR(outages->front().begin_s, drive.imu.front().t_s + 60.0, 1e-9);
  EXPECT_NEAR(outages->back().end_s, drive.imu.back().t_s, 1e-9);
  const auto too_long = spread_outages(drive, 200.0, 300.0, 1);
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().kind, base::ErrorKind::bad_input);
}

TEST(Outages, APipelineSeesNeitherTruthNorFixesOfTheOutageNorWhatCameLater) {
  const Drive drive = town({}, 1);
  const Outage outage{120.0, 150.0};
  bool was_asked = false;
  const Pipeline curious{"curious", "", [&](const Drive& seen, std::span<const double> t_s) {
                           was_asked = true;
                           EXPECT_TRUE(seen.truth.empty());
                           EXPECT_LE(seen.gnss.back().t_s, 120.0);
                           EXPECT_GE(seen.gnss.back().t_s, 119.0);
                           EXPECT_NEAR(seen.imu.back().t_s, 150.0, 0.021);
                           EXPECT_EQ(t_s.size(), 30u);
                           return base::Result<std::vector<Solution>>(std::vector<Solution>(t_s.size()));
                         }};
  const auto result = run_outage(drive, outage, {&curious, 1});
  ASSERT_TRUE(result);
  EXPECT_TRUE(was_asked);
  const Pipeline lazy{"lazy", "", [](const Drive&, std::span<const double>) {
                        return base::Result<std::vector<Solution>>(std::vector<Solution>());
                      }};
  EXPECT_FALSE(run_outage(drive, outage, {&lazy, 1}));
}

TEST(Outages, ErrorsAreThoseOfTheSolution) {
  const Drive drive = town({}, 1);
  const Pipeline off{"off", "", [&](const Drive&, std::span<const double> t_s) {
                       std::vector<Solution> solutions;
                       for (const double t : t_s) {
                         const TruthPoint& truth = drive.truth[static_cast<std::size_t>(std::lround(t))];
                         solutions.push_back({moved(truth.position, {3.0, -4.0, 2.0}), truth.velocity_mps});
                       }
                       return base::Result<std::vector<Solution>>(solutions);
                     }};
  const auto result = run_outage(drive, {100.0, 130.0}, {&off, 1});
  ASSERT_TRUE(result);
  const OutageErrors& errors = result->pipelines.front();
  EXPECT_LT((errors.position_final_m - Vector3d(3.0, -4.0, 2.0)).norm(), 1e-4);
  EXPECT_NEAR(errors.horizontal_rmse_m, 5.0, 1e-4);
  EXPECT_EQ(errors.velocity_rmse_mps, Vector3d::Zero());
  EXPECT_EQ(errors.points.size(), 30u);
}

TEST(Outages, AUnitWithoutErrorsKnowsItsWay) {
  const Drive drive = town({}, 3);
  const Pipeline pipeline = plain();
  const auto result = run_outage(drive, {200.0, 230.0}, {&pipeline, 1});
  ASSERT_TRUE(result);
  // What fixes leave: 0.01 m/s and 2 mrad for 30 s in up to 500 m, a tilt and a bias of 1 mrad together.
  EXPECT_LT(result->pipelines.front().horizontal_final_m, 5.0);
}

TEST(Outages, OneWayThroughTheDriveGivesWhatEachOutageGivesByItself) {
  const Drive drive = town(isi(), 4, [](calib::Sensor, double temp_c) { return 1e-4 * temp_c; });
  FilterPipeline physics{"physics", "", {}, {}, {}, true};
  physics.filter.sensors = typical_mems();
  physics.filter.scale_states = true;
  physics.filter.non_holonomic = NonHolonomic{};
  FilterPipeline corrected{"corrected", "", {}, {}, [](ImuSample& sample) { sample.rate_rps *= 1.001; }};
  corrected.filter.sensors = typical_mems();
  const std::vector<FilterPipeline> parts = {physics, corrected};
  const std::vector<Pipeline> pipelines = {filter_pipeline(physics), filter_pipeline(corrected)};
  // The second begins within the first, the third between two samples.
  const std::vector<Outage> outages = {{120.0, 150.0}, {140.0, 150.0}, {171.234, 190.0}};
  const auto together = run_outages_in_passing(drive, outages, parts);
  ASSERT_TRUE(together);
  ASSERT_EQ(together->size(), outages.size());
  for (std::size_t i = 0; i < outages.size(); ++i) {
    const auto alone = run_outage(drive, outages[i], pipelines);
    ASSERT_TRUE(alone);
    EXPECT_EQ((*together)[i].distance_m, alone->distance_m);
    for (std::size_t p = 0; p < pipelines.size(); ++p) {
      const OutageErrors& one = (*together)[i].pipelines[p];
      const OutageErrors& other = alone->pipelines[p];
      ASSERT_EQ(one.points.size(), other.points.size());
      EXPECT_GT(other.horizontal_final_m, 0.1);
      // A sample that an outage's beginning cuts in two has its coning computed in two pieces.
      EXPECT_LT((one.position_final_m - other.position_final_m).norm(), 1e-3) << "outage " << i << ", pipeline " << p;
    }
  }
}

TEST(Outages, OneWayThroughTheDriveIsRefusedToAnOutageBeforeTheFilterCanBegin) {
  const Drive drive = town({}, 1);
  FilterPipeline parts{"raw", "", {}, {}, {}};
  parts.filter.sensors = typical_mems();
  const auto refused = run_outages_in_passing(drive, std::vector<Outage>{{2.0, 32.0}}, {&parts, 1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  EXPECT_NE(refused.error().message.find("begins at 2.0 s"), std::string::npos);
  const auto unordered =
      run_outages_in_passing(drive, std::vector<Outage>{{150.0, 160.0}, {120.0, 130.0}}, {&parts, 1});
  EXPECT_FALSE(unordered);
}

TEST(Outages, ABiasThatStaysIsLearnt) {
  const Vector3d bias_mps2{0.15, -0.1, 0.2};
  const auto constant = [&](calib::Sensor sensor, double) {
    return calib::is_gyro(sensor) ? 0.3 * kRadPerDeg : bias_mps2[static_cast<int>(calib::axis_of(sensor))];
  };
  std::vector<Maneuver> maneuvers = {{40}, {10, 12.0}};
  for (int turn = 0; turn < 30; ++turn) maneuvers.push_back({20, 12.0, turn % 2 == 0 ? 2.0 : -2.0});
  const auto lost = [&](const ThermalBias& bias) {
    Drive drive = Trajectory(kOrigin, 0.3, maneuvers).drive(50, 50, {0.0, 0.5, 0.5});
    add_errors(drive.imu, {}, {20.0, 20.0, 100.0}, bias, 3);
    drive.gnss = simulated_fixes(drive.truth, 1, {}, 3);
    const Pipeline pipeline = plain();
    const auto result = run_outage(drive, {540.0, 570.0}, {&pipeline, 1});
    EXPECT_TRUE(result);
    return result ? result->pipelines.front().position_final_m : Vector3d::Constant(1e3);
  };
  // The fixes' own errors cost both the same. 2 mm/s² for 30 s; a filter that draws the bias to 0 loses 6 m.
  EXPECT_LT((lost(constant) - lost({})).norm(), 1.0);
}

TEST(Outages, NonHolonomicUpdatesHoldWhatAccelerometersLose) {
  const UnitErrors errors = ahrs400ca();
  FilterPipeline bound{"bound", "", {}, {}, {}};
  bound.filter.sensors = typical_mems();
  bound.filter.non_holonomic = NonHolonomic{};
  const std::vector<Pipeline> pipelines = {plain(), filter_pipeline(bound)};
  std::vector<OutageResult> results;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Drive drive = town(errors, seed);
    const auto result = run_outage(drive, {180.0, 210.0}, pipelines);
    ASSERT_TRUE(result);
    results.push_back(*result);
  }
  const auto summaries = summarize(results, pipelines, 1);
  EXPECT_GT(summaries[1].gain.value, 0.3);
  EXPECT_GT(summaries[1].gain.low, 0.0);
  EXPECT_EQ(summaries[0].gain.value, 0.0);
}

TEST(Outages, AThermalCorrectionPaysWhereTheTemperatureRuns) {
  const auto thermal = [](calib::Sensor sensor, double temp_c) {
    return calib::is_gyro(sensor) ? 0.5 * kRadPerDeg * (temp_c - 20.0) / 40.0 : 0.0;
  };
  UnitErrors errors = isi();
  FilterPipeline corrected{"corrected", "", {}, {}, {}};
  corrected.filter.sensors = typical_mems();
  corrected.correction = [&](ImuSample& sample) {
    sample.rate_rps -= Vector3d::Constant(thermal(calib::Sensor::gyro_x, sample.temp_c));
  };
  const std::vector<Pipeline> pipelines = {plain(), filter_pipeline(corrected)};
  const auto result = run_outage(town(errors, 2, thermal), {80.0, 110.0}, pipelines);
  ASSERT_TRUE(result);
  EXPECT_LT(result->pipelines[1].horizontal_final_m, 0.5 * result->pipelines[0].horizontal_final_m);
}

// On such drives a filter that believed the rest lost 65 m where the plain one lost 27 m.
TEST(Tuning, ARestDoesNotHoldABiasThatTheTemperatureWillMove) {
  UnitErrors quiet;
  quiet.gyro.white = 1e-4;
  quiet.accel.white = 1e-3;
  const SensorModels typical = typical_mems();
  const std::vector<Maneuver> maneuvers = {{40}, {10, 12.0}};
  Drive drive = Trajectory(kOrigin, 0.3, maneuvers).drive(50, 50, Vector3d::Zero());
  add_errors(drive.imu, quiet, {}, {}, 1);
  drive.gnss = simulated_fixes(drive.truth, 1, {}, 1);
  const SensorModels tuned = tuned_at_rest(drive, typical, AlignmentOptions{}.heading_sigma_rad);
  for (std::size_t k = 0; k < tuned.size(); ++k) {
    EXPECT_GE(tuned[k].bias.walk, typical[k].bias.walk);
    EXPECT_GE(tuned[k].white, typical[k].white);
  }
}

TEST(Tuning, TheStartOfAGyrosBiasHoldsWhatAWrongHeadingLeavesOfTheEarthsRotation) {
  UnitErrors quiet;
  quiet.gyro.white = 1e-7;
  quiet.accel.white = 1e-5;
  const std::vector<Maneuver> maneuvers = {{40}, {10, 12.0}};
  Drive drive = Trajectory(kOrigin, 0.3, maneuvers).drive(50, 50, Vector3d::Zero());
  add_errors(drive.imu, quiet, {}, {}, 1);
  drive.gnss = simulated_fixes(drive.truth, 1, {0.02, 0.04, 1e-6, 1e-6}, 1);
  // The vehicle slips aside by as much as one standard deviation of the heading.
  const AlignmentOptions options;
  const Eigen::AngleAxisd aside(options.heading_sigma_rad, Vector3d::UnitZ());
  for (GnssFix& fix : drive.gnss) fix.velocity_mps = aside * fix.velocity_mps;
  const auto start = align(drive, options);
  ASSERT_TRUE(start);
  const SensorModels tuned = tuned_at_rest(drive, {}, options.heading_sigma_rad);
  const double left_rps = options.heading_sigma_rad * 7.292115e-5 * std::cos(kOrigin.latitude_rad);
  EXPECT_NEAR(start->gyro_bias_rps.norm(), left_rps, 0.05 * left_rps);
  for (const calib::Sensor gyro : {calib::Sensor::gyro_x, calib::Sensor::gyro_y}) {
    const double sigma_rps = tuned[calib::index_of(gyro)].bias.start_sigma;
    EXPECT_LE(std::abs(start->gyro_bias_rps(static_cast<Eigen::Index>(calib::axis_of(gyro)))), sigma_rps);
    EXPECT_NEAR(sigma_rps, left_rps, 0.05 * left_rps);
  }
  // The upright gyro reads the same at any heading.
  EXPECT_LT(tuned[calib::index_of(calib::Sensor::gyro_z)].bias.start_sigma, 0.1 * left_rps);
}

TEST(Outages, ACorrectionSeesTheUnitsOwnAxes) {
  // Mounted with x forward, y to the left: what the unit calls x is the body's y.
  Drive drive = town({}, 1);
  drive.unit_to_body << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  Eigen::Vector3d seen_mps2 = Vector3d::Zero();
  FilterPipeline watching{"watching", "", {}, {}, [&](ImuSample& sample) {
                            if (sample.t_s > 139.99 && sample.t_s < 140.01) seen_mps2 = sample.force_mps2;
                          }};
  watching.filter.sensors = typical_mems();
  const std::vector<Pipeline> pipelines = {plain(), filter_pipeline(watching)};
  const auto result = run_outage(drive, {150.0, 160.0}, pipelines);
  ASSERT_TRUE(result);
  const Vector3d in_body = drive.imu[6999].force_mps2;
  EXPECT_LT((seen_mps2 - Vector3d(in_body.y(), -in_body.x(), in_body.z())).norm(), 1e-12);
  // A correction that changes nothing leaves the solution.
  EXPECT_LT((result->pipelines[0].position_final_m - result->pipelines[1].position_final_m).norm(), 1e-9);
}

TEST(Outages, AStopIsSeenAndHoldsTheVelocity) {
  // At rest from 0 to 25 s, then on, then at rest again: a stand of 30 s without fixes.
  const std::vector<Maneuver> maneuvers = {{25}, {10, 12.0}, {30, 12.0, 1.0}, {30, 12.0, -2.0}, {10, 0.0}, {40, 0.0}};
  Drive drive = Trajectory(kOrigin, 0.3, maneuvers).drive(50, 50, Vector3d::Zero());
  add_errors(drive.imu, ahrs400ca(), {}, {}, 9);
  drive.gnss = simulated_fixes(drive.truth, 1, {}, 9);
  FilterPipeline standing{"standing", "", {}, {}, {}};
  standing.filter.sensors = typical_mems();
  standing.filter.standstill = Standstill{1.0, 0.5 * kRadPerDeg, 0.1};
  FilterPipeline tuned = standing;
  tuned.filter.standstill.reset();
  tuned.tune_at_rest = true;  // finds such limits itself
  const std::vector<Pipeline> pipelines = {plain(), filter_pipeline(standing), filter_pipeline(tuned)};
  const auto result = run_outage(drive, {106.0, 144.0}, pipelines);
  ASSERT_TRUE(result);
  EXPECT_LT(result->pipelines[1].velocity_final_mps.norm(), 0.05);
  EXPECT_LT(result->pipelines[1].horizontal_final_m, 0.2 * result->pipelines[0].horizontal_final_m);
  EXPECT_LT(result->pipelines[2].velocity_final_mps.norm(), 0.05);
}

}  // namespace
}  // namespace soak::nav
