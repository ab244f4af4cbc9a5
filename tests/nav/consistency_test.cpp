// SPDX-License-Identifier: Apache-2.0
// Whether the filter knows how wrong it is: normalised errors over many simulated drives.
#include <gtest/gtest.h>

#include <vector>

#include "matched_drives.h"
#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr int kRuns = 100;

struct Statistics {
  std::vector<std::vector<double>> nees, position_nis, velocity_nis;
};

Statistics statistics_of(bool scale_states, double noise_factor = 1.0, int runs = kRuns) {
  Statistics all;
  FilterOptions options = matching(scale_states);
  for (SensorModel& model : options.sensors) {
    model.white *= noise_factor;
    model.bias.sigma *= noise_factor;
    model.bias.start_sigma *= noise_factor;
  }
  for (int run = 0; run < runs; ++run) {
    const Simulated made = simulated(run, scale_states);
    FilterRun filter(made.drive, made.start, options);
    auto& of_run = all.nees.emplace_back();
    auto& positions = all.position_nis.emplace_back();
    auto& velocities = all.velocity_nis.emplace_back();
    filter.on_fix = [&](const GnssFix&, const Innovation& position, const Innovation& velocity) {
      positions.push_back(position.nis);
      velocities.push_back(velocity.nis);
    };
    for (int t = 5; t <= kSeconds; t += 5) {
      filter.advance_to(t);
      of_run.push_back(nees(all_errors_of(filter.filter(), made, t), filter.filter().covariance()));
    }
    for (auto* list : {&positions, &velocities}) list->resize(kSeconds);
  }
  return all;
}

TEST(Consistency, ErrorsAndInnovationsAreAsLargeAsTheFilterSays) {
  const Statistics all = statistics_of(false);
  // Of 60 epochs 95 % should lie within; by the binomial distribution 52 or more do in 99.7 % of such tests. The 12
  // errors of a drive depend on each other: 9 of them.
  EXPECT_GE(share_within(all.position_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.velocity_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.nees, 15), 9.0 / 12.0);
}

/// The antenna moves as the unit, and turns about it with the body by the reading less bias and scale factor, over a
/// rotating Earth.
Vector3d antenna_velocity_by(const NavigationFilter& filter, const Vector3d& reading_rps) {
  const auto r = to_matrix(filter.state().body_to_level);
  const Vector3d rate_rps =
      (reading_rps - filter.gyro_bias_rps()).cwiseQuotient(Vector3d::Ones() + filter.gyro_scale());
  return filter.state().velocity_mps + r * cross(rate_rps, kLever_m) -
         cross(earth_rate_rps(filter.state().position.latitude_rad), r * kLever_m);
}

TEST(Consistency, TheVelocityOfTheAntennaIsThatOfOneEstimateAlsoAfterAFeedBack) {
  Start start;
  start.state.position = kOrigin;
  NavigationFilter filter(start, matching(true), kLever_m);
  const Vector3d reading_rps(0.1, -0.2, 0.5);
  filter.predict(reading_rps, {0.3, 0.2, 9.8}, 0.02);
  EXPECT_LT((filter.antenna_velocity_mps() - antenna_velocity_by(filter, reading_rps)).norm(), 1e-12);
  NavigationFilter::Errors errors = NavigationFilter::Errors::Zero();
  errors.segment<3>(12).setConstant(0.02);
  errors.segment<3>(18).setConstant(0.05);
  filter.feed_back(errors);
  EXPECT_LT((filter.antenna_velocity_mps() - antenna_velocity_by(filter, reading_rps)).norm(), 1e-12);
}

TEST(Consistency, TwentyOneStatesKnowTheirErrorsToo) {
  const Statistics all = statistics_of(true);
  EXPECT_GE(share_within(all.position_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.velocity_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.nees, 21), 9.0 / 12.0);
}

TEST(Consistency, AFilterThatTrustsItsSensorsTooMuchIsFound) {
  EXPECT_LT(share_within(statistics_of(false, 0.5, 30).nees, 15), 0.3);
}

TEST(NavigationFilter, TakesAComputedFixWhereItLeavesOutAReceivedOne) {
  Start start;
  start.state.position = kOrigin;
  NavigationFilter filter(start, FilterOptions{}, Vector3d::Zero());
  const GnssFix far{1.0, moved(kOrigin, {100.0, 0.0, 0.0}), Vector3d::Ones(), Vector3d::Zero(), Vector3d::Ones()};
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(filter.update_position(far).used);
  NavigationFilter helped = filter;
  helped.update_computed(far);
  // Both standard deviations are 1 m: half way.
  EXPECT_NEAR(offset_m(kOrigin, helped.antenna()).x(), 50.0, 1e-3);
  // What was left out stays counted: the eleventh received fix is used.
  EXPECT_FALSE(helped.update_position(far).used);
  EXPECT_TRUE(helped.update_position(far).used);
}

}  // namespace
}  // namespace soak::nav
