// SPDX-License-Identifier: Apache-2.0
// Readings through wavelets: what a solution knows, and what becomes of a drive with and without noise.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "nav/outages/outage_runner.h"
#include "nav/prefilter/wmra_pipeline.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;

Drive town(const UnitErrors& errors, std::uint64_t seed) {
  const auto maneuvers = town_drive(180, 15, seed);
  Drive drive =
      Trajectory({51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0}, 0.3, maneuvers).drive(100, 100, {0.0, 0.5, 0.5});
  drive.name = "town";
  add_errors(drive.imu, errors, {}, {}, seed);
  drive.gnss = simulated_fixes(drive.truth, 1, {}, seed);
  return drive;
}

FilterPipeline plain() {
  FilterPipeline parts{"raw", "", {}, {}, {}};
  parts.filter.sensors = typical_mems();
  return parts;
}

/// How far two solutions lie apart at 125 s where readings after `changed_s` are others.
double moved_by_m(const Pipeline& pipeline, double changed_s) {
  const Drive seen = with_outage(town(ahrs400ca(), 3), {120.0, 130.0});
  Drive changed = seen;
  for (ImuSample& sample : changed.imu) {
    if (sample.t_s > changed_s) sample.force_mps2.y() += 3.0;
  }
  const std::vector<double> t_s = {125.0};
  const auto before = pipeline.solve(seen, t_s);
  const auto after = pipeline.solve(changed, t_s);
  EXPECT_TRUE(before);
  EXPECT_TRUE(after);
  return offset_m(before->front().antenna, after->front().antenna).norm();
}

TEST(Wmra, LiveNoSolutionKnowsALaterReading) {
  EXPECT_EQ(moved_by_m(wmra(plain()), 125.001), 0.0);
  // Half a second of 3 m/s² before it is seen.
  EXPECT_NEAR(moved_by_m(wmra(plain()), 124.5), 0.5 * 3.0 * 0.25, 0.05);
}

TEST(Wmra, TheBatchLooksAheadAsItsDescriptionSays) {
  const Pipeline batch = wmra_batch(plain());
  EXPECT_GT(moved_by_m(batch, 125.001), 0.0);
  EXPECT_NE(batch.description.find("LOOKS AHEAD"), std::string::npos);
}

/// How far the ends of 30 s by the two pipelines lie from that of the filter alone.
std::vector<double> changes_m(const Drive& drive) {
  const std::vector<Pipeline> pipelines = {filter_pipeline(plain()), wmra(plain()), wmra_batch(plain())};
  const auto result = run_outage(drive, {130.0, 160.0}, pipelines);
  EXPECT_TRUE(result);
  const auto& alone_m = result->pipelines[0].position_final_m;
  return {(result->pipelines[1].position_final_m - alone_m).norm(),
          (result->pipelines[2].position_final_m - alone_m).norm()};
}

TEST(Wmra, ReadingsWithoutNoiseStayWhatTheyAre) {
  for (const double change_m : changes_m(town({}, 4))) EXPECT_LT(change_m, 0.05);
}

TEST(Wmra, OfNoiseSomethingIsTakenOffAndThePositionHardlyMoves) {
  // What three levels hold back averages out within 0.1 s; the biases that the filter learns in 130 s differ a little.
  for (const double change_m : changes_m(town(ahrs400ca(), 4))) {
    EXPECT_GT(change_m, 1e-4);
    EXPECT_LT(change_m, 0.8);
  }
}

TEST(Wmra, SmoothedReadingsKeepASlowMotionAndLoseNoise) {
  // Noise of 0.1 m/s² at 100 Hz, of which an eighth lies below 6.25 Hz; a motion of 0.5 Hz beside it.
  base::Random random(6);
  std::vector<ImuSample> samples(6000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].t_s = 0.01 * static_cast<double>(i + 1);
    samples[i].force_mps2.y() = std::sin(std::numbers::pi * samples[i].t_s) + 0.1 * random.gaussian();
  }
  for (const auto& smooth : {smoothed_live(samples, 2000), smoothed_batch(samples)}) {
    ASSERT_TRUE(smooth);
    double sum = 0.0;
    for (const ImuSample& sample : *smooth) {
      const double left_mps2 = sample.force_mps2.y() - std::sin(std::numbers::pi * sample.t_s);
      sum += left_mps2 * left_mps2;
    }
    const double left_share = sum / (0.01 * static_cast<double>(samples.size()));
    EXPECT_NEAR(left_share, 1.0 / 8.0, 0.03);
  }
}

TEST(Wmra, NoiseOfARestIsKnownOrRefused) {
  Drive drive = town(ahrs400ca(), 5);
  // Without the rest: the first fix in motion is within a second of the first sample.
  const double cut_s = 40.0;
  std::erase_if(drive.imu, [&](const ImuSample& sample) { return sample.t_s < cut_s; });
  const auto solved = wmra(plain()).solve(with_outage(drive, {120.0, 130.0}), std::vector<double>{125.0});
  ASSERT_FALSE(solved);
  EXPECT_EQ(solved.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(solved.error().where, "town");
}

}  // namespace
}  // namespace soak::nav
