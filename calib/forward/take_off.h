// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/gap/campaign/campaign.h"

namespace soak::calib::forward {

/// Takes what accepted terms say off the readings of a campaign, segments and blocks, so that a fit or a search for a
/// gap sees what is left: means lose what each mechanism adds, and the temperatures of sensors that lag become those of
/// their elements; `carried` names the terms, for what is beside the means. Nothing recorded is touched: `campaign` is
/// a copy for computing. Returns what could not be taken off and why, a sentence each. Cost: linear in blocks and logs,
/// per term.
[[nodiscard]] std::vector<std::string> take_off(const std::vector<ModelTerm>& terms, gap::LoggedCampaign& campaign);

}  // namespace soak::calib::forward
