// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "nav/drive/drive.h"
#include "nav/filter/navigation_filter.h"

/// Where a filter can begin: coarse alignment at rest and in motion. The filter does the fine one.
namespace soak::nav {

/// Pitch and roll of a unit at rest from its mean specific force in m/s²; heading 0.
[[nodiscard]] Euler leveled(const Eigen::Vector3d& mean_force_mps2);

/// When the rest at the beginning of a drive ends: 1 s before the first fix faster than 0.3 m/s. The time of the first
/// sample where there is no rest.
[[nodiscard]] double end_of_rest_s(const Drive& drive);

/// What is needed for a start.
struct AlignmentOptions {
  double least_speed_mps = 3.0;    ///< at which the course over ground is taken for the heading
  double least_rest_s = 5.0;       ///< below, the rest at the beginning is not used
  double tilt_sigma_rad = 0.02;    ///< of pitch and roll after a rest; three times as much without
  double heading_sigma_rad = 0.1;  ///< slip, and a mounting that points aside
};

/// A start at the first fix that is fast enough. A rest at the beginning of the drive (fixes slower than 0.3 m/s) gives
/// pitch, roll and the biases of the gyros (less the Earth's rotation), which then carry the attitude to the start;
/// without one, pitch and roll come from the specific force less the acceleration between two fixes, that of the
/// antenna about the unit taken off, and the biases begin at 0. Heading: course over ground less what the antenna moves
/// beside the unit in a turn; the vehicle drives forwards. The drive must be validate()d. Refuses (bad_input) a drive
/// that is never fast enough, or has no readings there.
[[nodiscard]] base::Result<Start> align(const Drive& drive, const AlignmentOptions& options);

}  // namespace soak::nav
