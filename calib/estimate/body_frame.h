// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/vocabulary/segment.h"

namespace soak::calib {

/// Directions of the place on Earth in a unit's body axes: orthogonal unit vectors.
struct Frame {
  Vector3 up{};
  Vector3 north{};
  Vector3 east{};
};

/// How far the true vertical leans from the fixture's ideal `up`, to north and to east, rad.
struct Tilt {
  double north_rad = 0.0;
  double east_rad = 0.0;
};

/// The body axes of a unit in `position`, whose azimuth is known, of a fixture with that heading (Position defines
/// both). `tilt` turns the whole frame.
[[nodiscard]] Frame frame_of(const Position& position, double site_azimuth_deg, const Tilt& tilt = {});

/// What is known of the headings in which a unit rested.
struct Headings {
  bool complete = false;  ///< those of all positions are known, and the fixture's
  bool begun = false;     ///< some position has an azimuth
  std::string missing;    ///< what to give, in a sentence; empty where complete
};

/// Judges the segments of a run. Those in which the fixture turns need no azimuth: over whole turns the horizontal part
/// of the Earth's rotation cancels.
[[nodiscard]] Headings headings_of(std::span<const Segment> segments, const Site& site);

/// The Earth's rotation along the local vertical and horizontally towards north, rad/s.
struct EarthRate {
  double vertical_rps = 0.0;    ///< 0 where the latitude is not known
  double horizontal_rps = 0.0;  ///< 0 where the latitude or some heading is not known
};
[[nodiscard]] EarthRate known_earth_rate(std::span<const Segment> segments, const Site& site);

/// Whether the fixture turns in the segment at a known rate other than 0.
[[nodiscard]] bool turns(const Segment& segment);

}  // namespace soak::calib
