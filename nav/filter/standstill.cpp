// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/standstill.h"

#include <algorithm>
#include <cmath>

#include "nav/filter/alignment.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr double kShortestRest_s = 20.0;

/// Largest standard deviation of any gyro and of any accelerometer.
struct Scatter {
  double rate_rps;
  double force_mps2;
};

Scatter scatter_of(std::span<const ImuSample> window) {
  const auto count = static_cast<double>(window.size());
  Vector3d rate = Vector3d::Zero();
  Vector3d force = Vector3d::Zero();
  for (const ImuSample& sample : window) {
    rate += sample.rate_rps / count;
    force += sample.force_mps2 / count;
  }
  Vector3d rate_squares = Vector3d::Zero();
  Vector3d force_squares = Vector3d::Zero();
  for (const ImuSample& sample : window) {
    rate_squares += (sample.rate_rps - rate).cwiseAbs2() / count;
    force_squares += (sample.force_mps2 - force).cwiseAbs2() / count;
  }
  return {std::sqrt(rate_squares.maxCoeff()), std::sqrt(force_squares.maxCoeff())};
}

}  // namespace

bool stands(std::span<const ImuSample> window, const Standstill& limits) {
  const Scatter scatter = scatter_of(window);
  return scatter.rate_rps < limits.rate_sigma_rps && scatter.force_mps2 < limits.force_sigma_mps2;
}

std::optional<Standstill> standstill_at_rest(const Drive& drive) {
  const double rest_end_s = end_of_rest_s(drive);
  if (rest_end_s - drive.imu.front().t_s < kShortestRest_s) return std::nullopt;
  Standstill limits;
  for (auto from = drive.imu.begin(); from->t_s + limits.window_s <= rest_end_s;) {
    const auto end = std::ranges::upper_bound(drive.imu, from->t_s + limits.window_s, {}, &ImuSample::t_s);
    const Scatter scatter = scatter_of(std::span(from, end));
    limits.rate_sigma_rps = std::max(limits.rate_sigma_rps, scatter.rate_rps);
    limits.force_sigma_mps2 = std::max(limits.force_sigma_mps2, scatter.force_mps2);
    from = end;
  }
  return limits;
}

}  // namespace soak::nav
