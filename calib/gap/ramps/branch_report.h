// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/ramps/detail/ramp_recording.h"
#include "calib/gap/report/gap_report.h"

namespace soak::calib::gap::ramps {

/// What branches predict of each other in a recording in one attitude without plateaus. Completes
/// `report`, whose unit and model are known. Named effects carry parameters of a fit to all rows. `named` needs three
/// branches, three quarters of the sensors with a gap explained by one mechanism, and a straight drift that does not do
/// as well; `unknown` where names are withheld or heating and cooling repeat; `cannot_judge` where branches differ and
/// nothing repeats, or branches are missing.
[[nodiscard]] GapReport judge_branches(const LoggedCampaign& campaign, const RampRecording& recording,
                                       GapReport report);

}  // namespace soak::calib::gap::ramps
