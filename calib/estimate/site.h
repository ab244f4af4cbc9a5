// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/segment.h"

/// Gravity and the Earth's rotation at the place of a run, and how a unit's body axes lie to them.
namespace soak::calib {

/// Magnitude of gravity, whether it had to be assumed, and how well it is known.
struct Gravity {
  double mps2 = 0.0;
  bool assumed = false;  ///< neither given nor computable: the standard value 9.80665 stands in
  std::optional<double> standard_uncertainty_mps2 = std::nullopt;  ///< absent = nobody has stated it
  std::string basis = {};                                          ///< where the uncertainty comes from
};

/// Normal gravity on the WGS 84 ellipsoid (Somigliana) in m/s² with the second-order free-air correction for the
/// height.
[[nodiscard]] double normal_gravity_mps2(double sin_latitude, double height_m);

/// The given value; else normal gravity on the WGS 84 ellipsoid (Somigliana) at the latitude with the second-order
/// free-air correction for height (0 where it is not given); else the standard value.
///
/// Standard uncertainty: of a given value it is not stated. Normal gravity differs from the real one by anomalies, of
/// 42 mGal root mean square over the Earth (variance 1795 mGal², Tscherning and Rapp 1974); 5e-4 m/s² is taken. An
/// unknown height adds ±1000 m, rectangular. The standard value stands for anything between equator and pole.
[[nodiscard]] Gravity gravity_at(const Site& site);

/// The site with the gravity of the register's reference, where the site itself gives none and the register does.
[[nodiscard]] Site with_reference_gravity(Site site, std::span<const ReferenceUse> references);

/// Component of the Earth's rotation along the local upward vertical, rad/s: Ω sin φ, north positive.
[[nodiscard]] double vertical_earth_rate_rps(double latitude_deg);

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

/// The Earth's rotation along the local vertical and horizontally towards north, rad/s.
struct EarthRate {
  double vertical_rps = 0.0;    ///< 0 where the latitude is not known
  double horizontal_rps = 0.0;  ///< 0 where the latitude or some heading is not known
};

/// All that is known of the place of a run, and of how the unit stood there.
struct Place {
  Gravity gravity;
  Headings headings;
  EarthRate earth;
  std::optional<double> latitude_deg;
  std::optional<double> azimuth_deg;  ///< of the fixture; absent where not all headings are known
};

/// Judges the segments of a run. Those in which the fixture turns need no azimuth: over whole turns the horizontal part
/// of the Earth's rotation cancels.
[[nodiscard]] Place place_of(std::span<const Segment> segments, const Site& site);

}  // namespace soak::calib
