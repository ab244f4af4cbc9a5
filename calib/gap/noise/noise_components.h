// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// How the blocks of one sensor scatter, standard deviations in its unit: block within placement, placement within
/// visit, visit within run. The runs' own offsets are free parameters of the base.
struct NoiseComponents {
  double block = 0.0;
  double placement = 0.0;
  double visit = 0.0;
  double block_dof = 0.0;
  double placement_dof = 0.0;
  double visit_dof = 0.0;
  bool replicated = false;  ///< whether runs repeat each other enough to say so
};

/// Nested analysis of variance of what differs between runs that repeat the same cell (plateau, sweep, occurrence,
/// position, block): an effect that the runs share drops out of it, so that the noise never comes from the fit's own
/// residual. `residual`: readings less the base, NaN where the sensor has none. Where runs share fewer than ten
/// degrees of freedom, the scatter within runs stands in and `replicated` is false.
[[nodiscard]] NoiseComponents noise_components(const Observations& observations, const Eigen::VectorXd& residual);

}  // namespace soak::calib::gap
