// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "nav/drive/drive.h"
#include "nav/filter/navigation_filter.h"

/// Where a unit was, judged with the fixes before and after: the smoother of Rauch, Tung and Striebel (AIAA Journal 3
/// (1965) 1445) over a closed-loop filter. Looks ahead: for references, not for pipelines.
namespace soak::nav {

/// What a filter went through from one moment to the next one with measurements. Errors are such as
/// NavigationFilter::feed_back() takes out.
struct FilterInterval {
  Eigen::MatrixXd begin;       ///< covariance P of the errors, after the measurements at its beginning
  Eigen::MatrixXd transition;  ///< Φ of the errors, from its beginning to its end
  Eigen::MatrixXd end;         ///< covariance P⁻ at its end, before the measurements there
  Eigen::VectorXd fed_back;    ///< what these took out of the estimate, K z
};

/// What is left in a filter's estimate at a moment as the measurements afterwards tell it.
struct LeftErrors {
  Eigen::VectorXd errors;      ///< to be taken out of the estimate
  Eigen::MatrixXd covariance;  ///< after that
};

/// Of all moments: the beginnings of the intervals, which follow each other, and the end of the last one. There nothing
/// comes afterwards, and the covariance is `last`. States that are known exactly may be among them.
[[nodiscard]] std::vector<LeftErrors> left_errors(std::span<const FilterInterval> intervals,
                                                  const Eigen::MatrixXd& last);

/// A unit and its antenna at a time, by all fixes of the drive.
struct SmoothedPoint {
  double t_s = 0.0;
  Geodetic antenna;
  Eigen::Vector3d antenna_velocity_mps;
  NavState state;
  Eigen::Vector3d gyro_bias_rps;
  Eigen::Vector3d accel_bias_mps2;
  Eigen::MatrixXd covariance;             ///< in the order of NavigationFilter::covariance()
  Eigen::Matrix3d antenna_covariance_m2;  ///< of the antenna's position, east, north, up
};

/// Runs a filter through the whole drive and back. `t_s` rise, from the start to the last sample. The drive must be
/// validate()d. Needs some 8 kB of memory (21 states: 15 kB) for each fix, other update and time, 8 kB more for each
/// time.
[[nodiscard]] std::vector<SmoothedPoint> smoothed(const Drive& drive, const Start& start, const FilterOptions& options,
                                                  std::span<const double> t_s);

}  // namespace soak::nav
