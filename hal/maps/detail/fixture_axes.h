// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/vocabulary/position.h"
#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

/// How the axes of a fixture lie while both stand at 0, as unit vectors in the fixture's own axes. Angles are
/// right-handed about them. At angles (a, b) the fixture is turned by R = R_outer(a) R_inner(b) from there.
struct AxisDirections {
  calib::Vector3 up{};
  calib::Vector3 outer{};
  calib::Vector3 inner{};
};

[[nodiscard]] double dot(const calib::Vector3& a, const calib::Vector3& b);

/// What points up at these angles, in the fixture's axes: R^T up.
[[nodiscard]] calib::Vector3 up_at(const AxisDirections& axes, const AxisAngles& angles);

/// Heading at these angles of the fixture's axis that follows cyclically the one nearest the vertical, clockwise seen
/// from above from where the one after `axes.up` points at (0, 0); -180 ... 180 degrees.
[[nodiscard]] double heading_deg(const AxisDirections& axes, const AxisAngles& angles);

/// +1 or -1 where turning about that axis is turning about the vertical at these angles (within 1 degree):
/// counter-clockwise seen from above, or clockwise. 0 where the axis lies otherwise.
[[nodiscard]] int sense_about_up(const AxisDirections& axes, FixtureAxis axis, const AxisAngles& angles);

/// The section [axes] of a fixture's map into `map`, whose quantities and actions have been read: axes, positions,
/// azimuths. Refuses what such a fixture needs of its quantities and the map does not have, angles beyond the limits of
/// their requests and angles at which another direction than that of the label points up.
void read_axes(const settings::Table& root, DeviceMap& map);

}  // namespace soak::hal
