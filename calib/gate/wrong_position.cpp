// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/units.h"
#include "calib/gate/checks.h"

namespace soak::calib::gate {
namespace {

/// Part of the up vector that the recorded accelerometers must see for a judgement.
constexpr double kSeen = 0.5;

/// The position of the six whose axis reads the largest part of gravity.
std::string looks_like(const Vector3& force, int sign_at_rest) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(force[i]) > std::abs(force[axis])) axis = i;
  }
  return {force[axis] * sign_at_rest < 0.0 ? '-' : '+', static_cast<char>('X' + axis)};
}

}  // namespace

void wrong_position(const View& view, std::vector<Finding>& findings) {
  if (!view.segment.position) return;
  Vector3 force{};
  double along = 0.0;
  double seen = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorStatistics& accel = view.segment.sensor[3 + i];
    if (accel.count == 0) continue;
    const double up = view.segment.position->up[i] * view.type.sign_at_rest;
    force[i] = accel.mean;
    along += up * accel.mean;
    seen += up * up;
    squares += accel.mean * accel.mean;
  }
  if (std::sqrt(seen) < kSeen || squares <= 0.0) return;
  // Both vectors as the recorded axes see them: cos = u·f / (|u|·|f|).
  const double angle_deg = base::kDegPerRad * std::acos(std::clamp(along / std::sqrt(seen * squares), -1.0, 1.0));
  if (angle_deg <= view.limits.position_deg) return;
  findings.push_back({"wrong_position", Severity::reject, std::nullopt,
                      fmt::format("labelled {}, but gravity points {:.0f} deg away from there (limit {:.0f} deg): it "
                                  "looks like {}; check the label, and the signs and order of the axes",
                                  view.segment.position->label, angle_deg, view.limits.position_deg,
                                  looks_like(force, view.type.sign_at_rest))});
}

}  // namespace soak::calib::gate
