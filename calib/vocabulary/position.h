// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace soak::calib {

/// Vector in body axes x, y, z.
using Vector3 = std::array<double, 3>;

/// An attitude in which a unit rests (or turns). `up` is the unit vector that points up, in the unit's body axes: `+Z`
/// means that the z accelerometer reads about +g (specific force).
///
/// A **heading** is that of the body axis which follows, cyclically, the one nearest the vertical (x after z; of two as
/// near, after the first), projected to the horizontal: clockwise from north, seen from above. With `up` it is the full
/// rotation. `azimuth_deg` is relative to the fixture: heading of the position = Site::azimuth_deg + azimuth_deg.
struct Position {
  std::string label;
  Vector3 up{};
  std::optional<double> azimuth_deg;  ///< relative to the fixture's heading, where it is known
  std::optional<double> rate_dps;     ///< rotation rate about `up`, where the fixture turns

  bool operator==(const Position&) const = default;
};

/// Labels of the six positions, + and − of each axis adjacent.
inline constexpr std::array<std::string_view, 6> kSixPositionLabels = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};

/// The position that one of the six labels names (`+X` ... `-Z`, also in lower case); nothing for another text.
inline std::optional<Position> position_named(std::string_view label) {
  if (label.size() != 2 || (label[0] != '+' && label[0] != '-')) return std::nullopt;
  const char letter = static_cast<char>(label[1] & ~0x20);
  if (letter < 'X' || letter > 'Z') return std::nullopt;
  Position position;
  position.label = {label[0], letter};
  position.up[static_cast<std::size_t>(letter - 'X')] = label[0] == '+' ? 1.0 : -1.0;
  return position;
}

}  // namespace soak::calib
