// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/gap/report/gap_report.h"

namespace soak::calib::gap {

/// The named effects of a report as terms of a model, in the report's order; only those of `names` where it is not
/// empty. Refuses (bad_input) a report without a named effect, and a name that it has not named, saying what it has.
[[nodiscard]] base::Result<std::vector<ModelTerm>> accepted_terms(const LoggedCampaign& campaign,
                                                                  const GapReport& report,
                                                                  const std::vector<std::string>& names);

}  // namespace soak::calib::gap
