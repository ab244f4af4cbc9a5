// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/estimate/site.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// What one plateau visit says of one sensor, SI.
struct PlateauEstimate {
  std::int32_t visit = 0;
  Sweep sweep = Sweep::unknown;
  std::optional<double> plateau_c;  ///< set point
  double temp_c = 0.0;              ///< mean of the segments' own temperatures: what the estimate belongs to
  double t_s = 0.0;                 ///< middle of the visit, device time
  double bias = 0.0;
  double bias_se = 0.0;
  /// Accelerometers whose axis was turned against gravity; gyros about whose axis the fixture turned at known rates,
  /// never gyros at rest.
  std::optional<double> scale_ppm;
  std::optional<double> scale_se_ppm;
  double bias_freedoms = 0.0;  ///< degrees of freedom of bias_se; 0 = many
  double scale_freedoms = 0.0;
};

/// A number and its standard error.
struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
  double freedoms = 0.0;  ///< degrees of freedom of the standard error; 0 = many
};

/// How far the true vertical leans from the fixture's ideal up, rad: the level error of the chamber's side, common to
/// all positions. Positive to north: the fixture's north side stands too high.
struct LevelError {
  Estimate north;
  Estimate east;
  /// Standard uncertainty of north and of east per that of the fixture's faces (each tilted by its own about two axes);
  /// not in their standard errors.
  std::array<double, 2> per_face_tilt{};
};

/// What one run says of one sensor.
struct SensorEstimate {
  std::vector<PlateauEstimate> plateaus;
  /// Response to specific force along x, y, z, one constant for the run. Accelerometer: misalignment (rad), 0 on its
  /// own axis. Gyro: bias per specific force in (rad/s)/(m/s²); where the horizontal part of the Earth's rotation was
  /// not removed, the entries off its own axis hold that too. Absent where the positions do not show it.
  std::array<std::optional<double>, 3> coupling;
  std::array<double, 3> coupling_se{};  ///< 0 of an entry that is 0 by the choice of the axes
  double coupling_freedoms = 0.0;       ///< degrees of freedom of coupling_se; 0 = many
  /// Gyro: response to rates about x, y, z beyond its own scale, rad; 0 on its own axis. Only where movements between
  /// rests show all of it (hand_turns.h).
  std::optional<std::array<Estimate, 3>> rate_coupling;
  /// Even-order term K₂ of an accelerometer, 1/(m/s²): the reading holds K₂·f². Absent where the positions do not show
  /// it. Faces that are not square to the others by ε look like K₂ = ε/g: a type B contribution not in its error.
  std::optional<Estimate> even_order;
  double reduced_chi_squared = 0.0;  ///< of the joint fit; 0 where nothing is left over
};

struct SixPositionEstimate {
  std::array<SensorEstimate, kSensorCount> sensor;
  Gravity gravity;
  std::optional<LevelError> level_error;
  std::string no_level_error;  ///< why there is none, in a sentence; empty where there is one
  bool with_headings = false;  ///< those of all positions at rest are known
  std::vector<Warning> warnings;
};

/// Six-position estimation of one unit in one run: one joint weighted fit per sensor over all its segments.
///
/// Per plateau visit p the unknowns are bias b_p, for accelerometers the scale error S_p, and a linear drift in plateau
/// time (random, zero mean, its variance estimated); shared by the run are the couplings. With specific force f = g·up:
///
///     accelerometer i: y = b_p + (1 + S_p) f_i + Σ_{j≠i} M_ij f_j + K₂ (f_i² − g²) + C (up_j² − up_k²) + d_p τ + e
///     gyro i:          y = b_p + (1 + S_p) ω up_i + Ω_v up_i + G_ii f_i + h(position) + d_p τ + e
///
/// **Which bias.** b_p is (up + down)/2 for both kinds. For accelerometers it is the bias at ±g: that at 0 g is
/// b_p − K₂ g². So its level comes from readings along gravity, which feel a tilt of the fixture in second order only;
/// horizontal positions, where a tilt of 0.05° is 9 mm/s², only sharpen its shape and show K₂ and M. Where positions do
/// not show K₂ (a warning says so) it counts as 0, and b_p is what all positions agree on.
///
/// C is what four horizontal faces that are not square leave once M and K₂ have had theirs. Without it that would pass
/// for a drift, the same in every visit, and reach the level of b: 14 mm/s² for faces 0.1° off. It is among the
/// unknowns where all four are there.
///
/// h, one constant for each position in which axis i is not vertical, takes up g-sensitivity and the horizontal part of
/// the Earth's rotation, unless that is known and subtracted (below); so the level of b comes from the
/// axis' own up/down pair, in which the vertical part cancels [AH05 eq. 6.7-6.8, signs corrected: bias = (up + down)/2,
/// scale error = (up − down)/(2g) − 1], and the other positions only sharpen it. Ω_v is subtracted where the latitude
/// is known. Each segment is first carried to the visit's mean temperature along the local slope of the curve itself
/// (second pass).
///
/// **Headings.** Where the site's azimuth and that of every position at rest are known, so are north and east in body
/// axes. With the latitude the horizontal part of the Earth's rotation is then subtracted from the gyros too. And the
/// level error is estimated from all accelerometers together (detail/joint_fit.h, fit_level), where the headings
/// separate it from misalignment, which turns with the body; `up` of every position is then tilted by it, and what its
/// standard error does to the accelerometers' is added to theirs. Warns (`heading_incomplete`) of azimuths that are of
/// no use as others are missing.
///
/// ω is the rate of positions in which the fixture turns about the vertical (Position::rate_dps), 0 elsewhere. They
/// show S_p of the gyro along the vertical where its visit has two rates (±ω, or ω and rest) and enter for no other
/// sensor: accelerometers read a centripetal acceleration of unknown lever arm, gyros across the axis their
/// misalignment. An error of the fixture's rate is an error of S: type B, not in its standard error. Standard errors
/// are pooled over the run, then inflated where the fit's residuals ask for it. Where no segment states one (0), the
/// residuals alone make them; 0 where those leave nothing over: not known.
///
/// Segments without plateau are not used. Without positions (one attitude) b_p is the mean reading. A missing position
/// costs accuracy, or the visit where its bias can then not be told apart: a warning says so.
[[nodiscard]] SixPositionEstimate estimate_six_positions(std::span<const Segment> segments, const Place& place,
                                                         const UnitType& type);
[[nodiscard]] inline SixPositionEstimate estimate_six_positions(std::span<const Segment> segments, const Site& site,
                                                                const UnitType& type) {
  return estimate_six_positions(segments, place_of(segments, site), type);
}

}  // namespace soak::calib
