// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/units.h"
#include "nav/filter/navigation_filter.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"

/// Drives whose errors are those that the filter takes for granted, and how wrong an estimate is in them.
namespace soak::nav {

inline constexpr int kSeconds = 60;
inline const Geodetic kOrigin{51.08 * base::kRadPerDeg, -114.13 * base::kRadPerDeg, 1045.0};
inline const Eigen::Vector3d kLever_m(0.2, 1.0, 0.6);

inline const UnitErrors kErrors{
    "", {0.0, 0.05 * base::kRadPerDeg, 60.0, 0.03 * base::kRadPerDeg, 0.002}, {0.0, 0.02, 60.0, 0.003, 0.001}};

inline FilterOptions matching(bool scale_states) {
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
  std::vector<ImuSample> biases;  ///< what is added to the readings beside noise and scale factor errors
  ImuSample scales;               ///< scale factor errors, 1 = 100 %
  Start start;
};

/// What a unit with these errors reads where there is `truth` all the time.
inline std::vector<ImuSample> readings_of(double truth, const Simulated& made, const UnitErrors& errors,
                                          std::uint64_t seed) {
  std::vector<ImuSample> samples = made.truth_imu;
  for (ImuSample& sample : samples) sample.rate_rps = sample.force_mps2 = Eigen::Vector3d::Constant(truth);
  add_errors(samples, errors, {}, {}, seed);
  return samples;
}

inline Simulated simulated(int run, bool scale_errors) {
  const auto maneuvers = town_drive(kSeconds, 0, 1000 + static_cast<std::uint64_t>(run));
  Simulated made;
  made.drive = Trajectory(kOrigin, 0.06 * run, maneuvers).drive(50, 10, kLever_m);
  made.truth_imu = made.drive.imu;
  UnitErrors errors = kErrors;
  if (!scale_errors) errors.gyro.scale_sigma = errors.accel.scale_sigma = 0.0;
  const auto seed = static_cast<std::uint64_t>(run);
  add_errors(made.drive.imu, errors, {}, {}, seed);
  errors.gyro.white = errors.accel.white = 0.0;
  made.biases = readings_of(0.0, made, errors, seed);
  made.scales = readings_of(1.0, made, errors, seed).front();
  made.scales.rate_rps -= Eigen::Vector3d::Ones() + made.biases.front().rate_rps;
  made.scales.force_mps2 -= Eigen::Vector3d::Ones() + made.biases.front().force_mps2;
  made.drive.gnss = simulated_fixes(made.drive.truth, 5, {}, seed);
  // The beginning is wrong by what it says.
  base::Random random(seed, 77);
  const auto noise = [&] { return Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()); };
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

/// Errors of position, velocity and attitude, estimate less truth. `sample`: of truth_imu, that ends at the truth's
/// time.
inline Eigen::VectorXd errors_of(const NavState& state, const TruthPoint& truth, const ImuSample& sample) {
  Eigen::VectorXd error(9);
  const auto r = to_matrix(*truth.body_to_level);
  const Geodetic unit = moved(truth.position, -(r * kLever_m));
  error.segment<3>(0) = offset_m(unit, state.position);
  error.segment<3>(3) = state.velocity_mps - (truth.velocity_mps - r * cross(sample.rate_rps, kLever_m));
  error.segment<3>(6) = -vector_of(quaternion_of(to_matrix(state.body_to_level) * r.transpose()));
  return error;
}

/// Errors of all states of the filter at `t_s`, a whole number from 1 on.
inline Eigen::VectorXd all_errors_of(const NavigationFilter& filter, const Simulated& made, int t_s) {
  const std::size_t sample = static_cast<std::size_t>(t_s) * 50 - 1;
  const TruthPoint& truth = made.drive.truth[static_cast<std::size_t>(t_s) * 5];
  const ImuSample& bias = made.biases[sample];
  Eigen::VectorXd error(21);
  error << errors_of(filter.state(), truth, made.truth_imu[sample]), bias.force_mps2 - filter.accel_bias_mps2(),
      bias.rate_rps - filter.gyro_bias_rps(), made.scales.force_mps2 - filter.accel_scale(),
      made.scales.rate_rps - filter.gyro_scale();
  return error.head(filter.covariance().rows());
}

/// εᵀ P⁻¹ ε of the first errors of the covariance.
inline double nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(base::solve_llt(covariance.topLeftCorner(error.size(), error.size()), error));
}

/// Mean over the runs of each statistic at each epoch, with the share of epochs within the 95 % bounds.
inline double share_within(const std::vector<std::vector<double>>& by_run, int degrees_of_freedom) {
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

}  // namespace soak::nav
