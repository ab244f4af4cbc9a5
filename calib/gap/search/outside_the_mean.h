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

/// Looks for `narrow_bump` in the levels of the saturated base, which takes up any feature of the curve. However steep
/// a smooth curve is, it is not named: of a sensor with a bump at a level,
/// - the curvature turns and turns back within the two levels on either side, some 5 K from one to the next, each of
/// the
///   three signs sure against the levels' own covariance (an intersection-union test, exact for any curve whose
///   curvature does not do that);
/// - the bump stands out of how far a smooth curve strays between its levels (smooth_curve.h), the scale of that taken
///   from the levels with the bump allowed for: where the whole curve is wavy none stands out, and none is named where
///   its correlation length is below 1.9 distances of the levels;
/// - it is ten times as likely as the best kink or step in its place.
/// The largest of the first two chances is that of the sensor; those of several sensors at one level are pooled, and
/// adjusted for all levels and sets of sensors. What fails only by the third is said in `not_testable`. Not testable
/// with fewer than twelve levels, or where none has neighbours within 7.5 K.
[[nodiscard]] OutsideTheMean look_for_bump(const CampaignModel& model);

}  // namespace soak::calib::gap
