// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "nav/drive/drive.h"
#include "nav/filter/navigation_filter.h"
#include "nav/outages/pipeline.h"

/// What a filter's error may be read from while there are no fixes, and artificial outages, in which it is known.
namespace soak::nav {

/// The ten inputs of [AH05 §7.1.1], heading as two numbers: seconds since the last fix; specific forces in m/s² and
/// rates in rad/s along right, forward, up; pitch and roll in rad, sine and cosine of the heading.
inline constexpr std::size_t kErrorInputs = 11;
using ErrorInputs = std::array<double, kErrorInputs>;

/// East, north, up of the position, then of the velocity.
inline constexpr std::size_t kErrorOutputs = 6;
using ErrorOutputs = Eigen::Matrix<double, kErrorOutputs, 1>;

/// The inputs at a time: readings are means over the last second, the attitude is the filter's.
[[nodiscard]] ErrorInputs error_inputs(const Drive& drive, const NavigationFilter& filter, double now_s,
                                       double since_fix_s);

/// The antenna's position in m and velocity in m/s by one filter less those by another.
[[nodiscard]] ErrorOutputs error_outputs(const NavigationFilter& filter, const NavigationFilter& reference);

/// What a filter without fixes was wrong by at the time of a fix.
struct ErrorRow {
  double t_s = 0.0;
  ErrorInputs inputs{};
  ErrorOutputs error;
};

/// The rows of one artificial outage.
struct ErrorWindow {
  double begin_s = 0.0;
  std::vector<ErrorRow> rows;
};

/// Artificial outages of a drive, beginning at `begins_s` (rising): in each the same filter goes on without fixes, and
/// its error against the one that has them is noted at each fix [AH05 fig. 7.1]. Time counts from the last fix before,
/// as in a real outage. An outage before the filter's start, or one that holds no fix, has no rows.
[[nodiscard]] std::vector<ErrorWindow> error_windows(const FilterSetup& setup, std::span<const double> begins_s,
                                                     double length_s);

/// Where artificial outages begin that follow each other without a gap and end with the last fix; the first begins
/// `settling_s` after the filter's start or later.
[[nodiscard]] std::vector<double> successive_begins(const FilterSetup& setup, double length_s, double settling_s);

}  // namespace soak::nav
