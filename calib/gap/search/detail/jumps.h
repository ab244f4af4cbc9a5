// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/detail/slow_noise.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// Looks for a bias that jumps, and stays there for a while: once (a step) or to and fro (telegraph noise), against the
/// model's noise, in which a bias may wander. In each run the step between two placements that stands out most, over
/// all places where one may be; how much stronger or weaker each of `effects` was in a run is taken off. The step of a
/// sensor that stands out most of all is judged by noise that was estimated without it. And over all runs two levels,
/// alone (chance_of_telegraph) and beside a wander (chance_of_jumps_beside_wander). Of a set of sensors the chance is
/// that of all its runs together, of the run that stands out most, or of two levels, whichever is least. Nothing where
/// the chance, adjusted, is above that of slow_noise(). What is found lists the
/// steps that stand out. It is telegraph noise where a step the other way stands out beside one of them in the same
/// run, further off than the next place where one was looked for, or where no step stands out and two levels tell of it
/// most; else a step where they are all of one run, and jumps where they are not, or where none stands out.
[[nodiscard]] std::optional<SlowNoise> jumps(const CampaignModel& model, const std::vector<NamedEffect>& effects);

}  // namespace soak::calib::gap
