// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// An effect that a campaign cannot show.
struct NotTestable {
  std::string name;
  std::string why;
};

/// Effects that leave the means within a run alone: the gap in the mean cannot close by them.
struct OutsideTheMean {
  std::vector<NamedEffect> effects;
  std::vector<NotTestable> not_testable;

  void add(OutsideTheMean&& other);
};

/// Looks for `aging_drift`, under the gate of the search: the runs' offsets against the time of the runs (at least four
/// runs, R − 2 degrees of freedom). Its candidate has the time of each observation in hours as its column: what ages
/// also drifts a little within a run.
[[nodiscard]] OutsideTheMean look_for_aging(const LoggedCampaign& campaign, const CampaignModel& model);

/// Looks, each under the gate of the search, for
/// - `noise_vs_temperature`: the logarithm of the blocks' variances against temperature, run by run; of its sensors
///   those that stand out by themselves, with a tenth of the largest slope or more;
/// - `quantization`: samples on a lattice of more than a tenth of their noise;
/// - `saturation`: samples that stick at the ends.
/// What the model carries is not found again: its noise slope is taken off, its steps count where they have become half
/// as large again, and a sensor that it has stop at the ends is known to.
[[nodiscard]] OutsideTheMean look_outside_the_mean(const LoggedCampaign& campaign, const CampaignModel& model);

/// Distance of each inner level from the cubic through its two neighbours on either side; NaN for the two at each end.
[[nodiscard]] Eigen::VectorXd off_neighbours(const std::vector<double>& level_c, const Eigen::VectorXd& levels);

/// Looks for `narrow_bump` in the levels of the saturated base, which takes up any feature of the curve: a level that
/// lies off the cubic through its neighbours by much more than the others lie off theirs (Student's t, with as many
/// degrees of freedom as levels that do not touch it; a wavy curve has a wide scatter and raises nothing), in one
/// sensor or in several at the same temperature. Adjusted for all levels and sets of sensors; under the gate of the
/// search. Not testable with fewer than twelve levels: they do not say how smooth the curve is.
[[nodiscard]] OutsideTheMean look_for_bump(const CampaignModel& model);

}  // namespace soak::calib::gap
