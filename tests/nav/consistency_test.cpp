// SPDX-License-Identifier: Apache-2.0
// Whether the filter knows how wrong it is: normalised errors over many simulated drives.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/units.h"
#include "nav/filter/filter_run.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kRuns = 100;
constexpr int kSeconds = 60;
const Geodetic kOrigin{51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0};
const Vector3d kLever_m(0.2, 1.0, 0.6);

const UnitErrors kErrors{"", {0.0, 0.05 * kRadPerDeg, 60.0, 0.03 * kRadPerDeg, 0.002}, {0.0, 0.02, 60.0, 0.003, 0.001}};

FilterOptions matching(bool scale_states) {
  const auto model = [](const SensorErrors& errors) {
    return SensorModel{
        errors.white, {errors.markov_sigma, errors.markov_sigma, errors.markov_time_s, 0.0}, errors.scale_sigma};
  };
  FilterOptions options;
  options.sensors = same_for_axes(model(kErrors.gyro), model(kErrors.accel));
  options.scale_states = scale_states;
  options.gate_probability = 0.0;
  return options;
}

/// A drive of 60 s at 50 Hz with fixes each second, and the errors that the filter assumes.
struct Simulated {
  Drive drive;
  std::vector<ImuSample> truth_imu;
  Start start;
};

Simulated simulated(int run, bool scale_errors) {
  const auto maneuvers = town_drive(kSeconds, 0, 1000 + static_cast<std::uint64_t>(run));
  Simulated made;
  made.drive = Trajectory(kOrigin, 0.06 * run, maneuvers).drive(50, 10, kLever_m);
  made.truth_imu = made.drive.imu;
  UnitErrors errors = kErrors;
  if (!scale_errors) errors.gyro.scale_sigma = errors.accel.scale_sigma = 0.0;
  const auto seed = static_cast<std::uint64_t>(run);
  add_errors(made.drive.imu, errors, {}, {}, seed);
  made.drive.gnss = simulated_fixes(made.drive.truth, 5, {}, seed);
  // The beginning is wrong by what it says.
  base::Random random(seed, 77);
  const auto noise = [&] { return Vector3d(random.gaussian(), random.gaussian(), random.gaussian()); };
  const TruthPoint& first = made.drive.truth.front();
  Start& start = made.start;
  start.position_sigma_m = {0.5, 0.5, 0.5};
  start.velocity_sigma_mps = {0.1, 0.1, 0.1};
  start.attitude_sigma_rad = {0.01, 0.01, 0.03};
  const auto r = to_matrix(*first.body_to_level);
  start.state.position = moved(first.position, start.position_sigma_m.cwiseProduct(noise()) - r * kLever_m);
  start.state.velocity_mps = first.velocity_mps + start.velocity_sigma_mps.cwiseProduct(noise());
  start.state.body_to_level = rotation_of(-start.attitude_sigma_rad.cwiseProduct(noise())) * *first.body_to_level;
  return made;
}

/// εᵀ P⁻¹ ε of the states that the truth is known of: position, velocity, attitude.
double nees(const NavigationFilter& filter, const TruthPoint& truth, const Vector3d& rate_over_ground_rps) {
  VectorXd error(9);
  const auto r = to_matrix(*truth.body_to_level);
  const Geodetic unit = moved(truth.position, -(r * kLever_m));
  error.segment<3>(0) = offset_m(unit, filter.state().position);
  error.segment<3>(3) = filter.state().velocity_mps - (truth.velocity_mps - r * cross(rate_over_ground_rps, kLever_m));
  error.segment<3>(6) = -vector_of(quaternion_of(to_matrix(filter.state().body_to_level) * r.transpose()));
  return error.dot(base::solve_llt(filter.covariance().topLeftCorner(9, 9), error));
}

/// Mean over the runs of each statistic at each epoch, with the share of epochs within the 95 % bounds.
double share_within(const std::vector<std::vector<double>>& by_run, int degrees_of_freedom) {
  const double all = static_cast<double>(by_run.size()) * degrees_of_freedom;
  const double low = base::chi_squared_quantile(0.025, all) / static_cast<double>(by_run.size());
  const double high = base::chi_squared_quantile(0.975, all) / static_cast<double>(by_run.size());
  int within = 0;
  for (std::size_t k = 0; k < by_run.front().size(); ++k) {
    double mean = 0.0;
    for (const auto& run : by_run) mean += run[k] / static_cast<double>(by_run.size());
    within += mean >= low && mean <= high ? 1 : 0;
  }
  return within / static_cast<double>(by_run.front().size());
}

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
      const std::size_t truth = static_cast<std::size_t>(t) * 5;
      const Vector3d rate = made.truth_imu[static_cast<std::size_t>(t) * 50 - 1].rate_rps;
      of_run.push_back(nees(filter.filter(), made.drive.truth[truth], rate));
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
  EXPECT_GE(share_within(all.nees, 9), 9.0 / 12.0);
}

TEST(Consistency, TwentyOneStatesKnowTheirErrorsToo) {
  const Statistics all = statistics_of(true);
  EXPECT_GE(share_within(all.position_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.velocity_nis, 3), 52.0 / 60.0);
  EXPECT_GE(share_within(all.nees, 9), 9.0 / 12.0);
}

TEST(Consistency, AFilterThatTrustsItsSensorsTooMuchIsFound) {
  EXPECT_LT(share_within(statistics_of(false, 0.5, 30).nees, 9), 0.3);
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
