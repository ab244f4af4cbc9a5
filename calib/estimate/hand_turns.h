// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/estimate/moves.h"
#include "calib/estimate/six_position.h"
#include "calib/vocabulary/position.h"

namespace soak::calib {

/// A unit at rest, as the gyros' calibration takes it.
struct RestAttitude {
  double t_start_s = 0.0;  ///< device time
  double t_end_s = 0.0;
  Vector3 up{};        ///< unit vector in body axes, as the calibrated accelerometers see it
  Vector3 rate_rps{};  ///< mean readings of the gyros
};

/// Gains of a gyro triad: raw = K·ω + b + G·f. Row i of `gain_error` is that of K − 1: its diagonal the scale errors,
/// the rest the misalignment, rad. Absent: the movements do not show it; misalignments that are not shown count as 0.
struct GyroGains {
  std::array<std::array<std::optional<Estimate>, 3>, 3> gain_error;
  std::size_t tilts = 0;        ///< movements to another attitude that were used
  std::size_t turns = 0;        ///< movements about the vertical through a stated angle that were used
  std::size_t open_turns = 0;   ///< movements about the vertical by over 60° of which nobody stated the angle
  std::size_t saturated = 0;    ///< movements that were left out, as a gyro was at its limit
  std::size_t with_gaps = 0;    ///< and as samples are missing
  double tilt_sigma_rad = 0.0;  ///< scatter of what the tilts leave, about one axis; 0 without tilts
  double turn_sigma_rad = 0.0;  ///< and the turns; 0 without turns
};

/// Estimates gains from movements between rests. The gyros' readings, less bias, are integrated to the rotation from
/// one rest to the next (trapezoids with the coning term of a rate that changes linearly), and compared with what is
/// known of it:
///
/// - *tilt*: the vertical seen from the attitude before must come to lie where the accelerometers see it in the
/// attitude
///   after (Tedaldi, Pretto, Menegatti, ICRA 2014, eq. 11-14): two equations of each movement.
/// - *turn*: where the movement ends with the vertical where it was (within 5°), a stated angle about it is the third:
///   the rotation must be through that angle (after Ferraris, Grimaldi, Parvis, Sensors and Materials 1995). A stated
///   angle that the gyros miss by more than a fifth is not that of this movement. A table that is not level does not
///   matter where the unit comes back to its place.
///
/// Bias at rest is a line in time, and a response to gravity (which acts during the movement too), fitted to the rests;
/// its error is an unknown with the
/// standard error of that fit. `with_tilts` false: the accelerometers' misalignment is not known, so their vertical is
/// not good enough for tilts; turns about the faces then show scale errors alone.
///
/// Weighted least squares, nonlinear. The variances of tilts and turns are estimated with it (Förstner 1979: each from
/// its own residuals and redundancy), as nobody knows how true a hand is; standard errors carry the degrees of freedom
/// of those (Satterthwaite). A kind of movement with a redundancy below 1 is left out: nothing would say how good it
/// is.
///
/// Refuses gyros that do not follow the movements at all: residuals of over 15°, a scale error beyond 20 %.
[[nodiscard]] base::Result<GyroGains> estimate_gains(std::span<const RestAttitude> rests, std::span<const Move> moves,
                                                     bool with_tilts);

}  // namespace soak::calib
