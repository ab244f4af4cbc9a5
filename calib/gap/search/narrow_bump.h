// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/search/outside_the_mean.h"

namespace soak::calib::gap {

/// Distance of each inner level from the cubic through its two neighbours on either side; NaN for the two at each end.
[[nodiscard]] Eigen::VectorXd off_neighbours(const std::vector<double>& level_c, const Eigen::VectorXd& levels);

/// Looks for `narrow_bump` in the levels of the saturated base, which takes up any feature of the curve: a level that
/// lies off the cubic through its neighbours by much more than the others lie off theirs (Student's t, with as many
/// degrees of freedom as levels that do not touch it; a wavy curve has a wide scatter and raises nothing), in one
/// sensor or in several at the same temperature. Adjusted for all levels and sets of sensors; under the gate of the
/// search. Not testable with fewer than twelve levels: they do not say how smooth the curve is.
[[nodiscard]] BesideTheMean look_for_bump(const CampaignModel& model);

}  // namespace soak::calib::gap
