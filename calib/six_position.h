// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calib/gravity.h"
#include "calib/segment.h"
#include "calib/unit_type.h"
#include "calib/warning.h"

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
  std::optional<double> scale_ppm;  ///< accelerometers whose axis pointed up and down; never gyros at rest
  std::optional<double> scale_se_ppm;
};

/// What one run says of one sensor.
struct SensorEstimate {
  std::vector<PlateauEstimate> plateaus;
  /// Response to specific force along x, y, z, one constant for the run. Accelerometer: misalignment (rad), 0 on its
  /// own axis. Gyro: bias per specific force in (rad/s)/(m/s²); where the horizontal part of the Earth's rotation was
  /// not removed, the entries off its own axis hold that too. Absent where the positions do not show it.
  std::array<std::optional<double>, 3> coupling;
  std::array<double, 3> coupling_se{};
  double reduced_chi_squared = 0.0;  ///< of the joint fit; 0 where nothing is left over
};

struct SixPositionEstimate {
  std::array<SensorEstimate, kSensorCount> sensor;
  Gravity gravity;
  std::vector<Warning> warnings;
};

/// Six-position estimation of one unit in one run: one joint weighted fit per sensor over all its segments.
///
/// Per plateau visit p the unknowns are bias b_p, for accelerometers the scale error S_p, and a linear drift in plateau
/// time (random, zero mean, its variance estimated); shared by the run are the couplings. With specific force f = g·up:
///
///     accelerometer i: y = b_p + (1 + S_p) f_i + Σ_{j≠i} M_ij f_j + d_p τ + e
///     gyro i:          y = b_p + Ω_v up_i + G_ii f_i + h(position) + d_p τ + e
///
/// h, one constant for each position in which axis i is not vertical, takes up g-sensitivity and the horizontal part of
/// the Earth's rotation, which nobody knows without every position's full rotation; so the level of b comes from the
/// axis' own up/down pair, in which the vertical part cancels [AH05 eq. 6.7-6.8, signs corrected: bias = (up + down)/2,
/// scale error = (up − down)/(2g) − 1], and the other positions only sharpen it. Ω_v is subtracted where the latitude
/// is known. Each segment is first carried to the visit's mean temperature along the local slope of the curve itself
/// (second pass). Standard errors are pooled over the run, then inflated where the fit's residuals ask for it.
///
/// Segments without plateau are not used. Without positions (one attitude) b_p is the mean reading. A missing position
/// costs accuracy, or the visit where its bias can then not be told apart: a warning says so.
[[nodiscard]] SixPositionEstimate estimate_six_positions(std::span<const Segment> segments, const Site& site,
                                                         const UnitType& type);

}  // namespace soak::calib
