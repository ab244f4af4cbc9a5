// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/detail/slow_noise.h"

namespace soak::calib::gap {

/// Looks for a bias that jumps, and stays there for a while: once (a step) or to and fro (telegraph noise). To be told
/// from one that wanders, whose changes are as likely small as its noise says (CampaignModel::wanders()): in each run
/// the step between two placements that stands out most, against that noise, over all places where one may be.
/// Nothing where the chance, adjusted for sensors and places, is above that of slow_noise().
[[nodiscard]] std::optional<SlowNoise> jumps(const CampaignModel& model);

}  // namespace soak::calib::gap
