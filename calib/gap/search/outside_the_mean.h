// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

struct NotTestable {
  std::string name;
  std::string why;
};

/// Effects that leave the means within a run alone: the gap in the mean cannot close by them.
struct BesideTheMean {
  std::vector<NamedEffect> effects;
  std::vector<NotTestable> not_testable;
};

/// Looks for `aging_drift`, under the gate of the search: the runs' offsets against the time of the runs (at least four
/// runs, R − 2 degrees of freedom). Its candidate has the time of each observation in hours as its column: what ages
/// also drifts a little within a run.
[[nodiscard]] BesideTheMean look_for_aging(const LoggedCampaign& campaign, const CampaignModel& model);

/// Looks, each under the gate of the search, for
/// - `noise_vs_temperature`: the logarithm of the blocks' variances against temperature, run by run; of its sensors
/// those
///   that stand out by themselves, with a tenth of the largest slope or more;
/// - `quantization`: samples on a lattice of more than a tenth of their noise;
/// - `saturation`: samples that stick at the ends.
/// What the model carries is not found again: its noise slope is taken off, its steps count where they have become half
/// as large again, and a sensor that it has stop at the ends is known to.
[[nodiscard]] BesideTheMean look_beside_the_mean(const LoggedCampaign& campaign, const CampaignModel& model);

}  // namespace soak::calib::gap
