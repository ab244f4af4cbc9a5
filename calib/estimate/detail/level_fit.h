// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "calib/estimate/detail/problem.h"

namespace soak::calib::six_position {

/// The tilt of the vertical to north and to east, in that order, rad.
struct LevelFit {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< from the readings
  /// Standard uncertainty per that of the faces, each of them tilted about two axes by its own.
  Eigen::Vector2d per_face_tilt = Eigen::Vector2d::Zero();
};

/// What fit_level() says: the tilt, or why the segments do not show it.
struct LevelAnswer {
  std::optional<LevelFit> fit;
  std::string reason;  ///< empty where there is a fit
};

/// One weighted least squares over all accelerometers of a run: the two tilts in common, every other unknown of the
/// joint fits (bias, scale error and drift of each visit, misalignment, even-order term) each accelerometer's own.
///
/// A body's misalignment turns with the body, the vertical does not: so what a tilt does to the readings changes with
/// the heading. Where the headings allow it (a face at several of them) the contrasts of the horizontal faces are among
/// the unknowns, and no error of a face reaches the tilt. Else they count as 0, since with them the four horizontal
/// readings of an accelerometer have four unknowns of their own; the faces' errors then reach it by `per_face_tilt`.
///
/// Not shown where less than 2 % of what the readings know of some direction is left beside the other unknowns.
[[nodiscard]] LevelAnswer fit_level(std::span<const Problem> accelerometers);

}  // namespace soak::calib::six_position
