// SPDX-License-Identifier: Apache-2.0
#include "nav/learned/error_windows.h"

#include <algorithm>
#include <cmath>
#include <list>

#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

constexpr double kMeanOver_s = 1.0;
/// Times closer than this are the same.
constexpr double kSame_s = 1e-6;

/// An outage on its way.
struct Going {
  FilterRun run;
  ErrorWindow* window;
  double last_fix_s;  ///< before it began: from here a real outage counts
};

}  // namespace

ErrorInputs error_inputs(const Drive& drive, const NavigationFilter& filter, double now_s, double since_fix_s) {
  // Times that were computed in another way may lie a rounding beside the sample's.
  const auto end = std::ranges::upper_bound(drive.imu, now_s + kSame_s, {}, &ImuSample::t_s);
  auto first = std::ranges::upper_bound(drive.imu, now_s - kMeanOver_s + kSame_s, {}, &ImuSample::t_s);
  if (first == end) first = std::prev(end);
  Vector3d force = Vector3d::Zero();
  Vector3d rate = Vector3d::Zero();
  const double share = 1.0 / static_cast<double>(end - first);
  for (; first != end; ++first) {
    force += share * first->force_mps2;
    rate += share * first->rate_rps;
  }
  const Euler angles = euler_of(to_matrix(filter.state().body_to_level));
  return {since_fix_s,
          force.x(),
          force.y(),
          force.z(),
          rate.x(),
          rate.y(),
          rate.z(),
          angles.pitch_rad,
          angles.roll_rad,
          std::sin(angles.heading_rad),
          std::cos(angles.heading_rad)};
}

ErrorOutputs error_outputs(const NavigationFilter& filter, const NavigationFilter& reference) {
  ErrorOutputs error;
  error << offset_m(reference.antenna(), filter.antenna()),
      filter.antenna_velocity_mps() - reference.antenna_velocity_mps();
  return error;
}

std::vector<ErrorWindow> error_windows(const FilterSetup& setup, std::span<const double> begins_s, double length_s) {
  std::vector<ErrorWindow> windows;
  for (const double begin_s : begins_s) windows.push_back({begin_s, {}});
  FilterRun with_fixes(setup.drive, setup.start, setup.options);
  std::list<Going> going;
  double last_fix_s = setup.start.t_s;
  auto next = std::ranges::lower_bound(begins_s, setup.start.t_s) - begins_s.begin();
  for (const GnssFix& fix : setup.drive.gnss) {
    if (fix.t_s <= setup.start.t_s) continue;
    for (; next < std::ssize(windows) && begins_s[static_cast<std::size_t>(next)] < fix.t_s - kSame_s; ++next) {
      ErrorWindow& window = windows[static_cast<std::size_t>(next)];
      with_fixes.advance_to(window.begin_s);
      going.push_back({with_fixes, &window, last_fix_s});
      going.back().run.lose_fixes();
    }
    std::erase_if(going, [&](const Going& outage) { return fix.t_s > outage.window->begin_s + length_s + kSame_s; });
    with_fixes.advance_to(fix.t_s);
    last_fix_s = fix.t_s;
    for (Going& outage : going) {
      outage.run.advance_to(fix.t_s);
      const NavigationFilter& filter = outage.run.filter();
      outage.window->rows.push_back({fix.t_s, error_inputs(setup.drive, filter, fix.t_s, fix.t_s - outage.last_fix_s),
                                     error_outputs(filter, with_fixes.filter())});
    }
  }
  return windows;
}

std::vector<double> successive_begins(const FilterSetup& setup, double length_s, double settling_s) {
  std::vector<double> begins_s;
  const double first_s = setup.start.t_s + settling_s;
  for (double begin_s = setup.drive.gnss.back().t_s - length_s; begin_s >= first_s; begin_s -= length_s) {
    begins_s.push_back(begin_s);
  }
  std::ranges::reverse(begins_s);
  return begins_s;
}

}  // namespace soak::nav
