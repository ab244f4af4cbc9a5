// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/campaign/campaign.h"

namespace soak::calib::gap {

/// Where the unit's thermometer moves in steps of 0.1 K or more and every run at plateaus logged the chamber's air,
/// replaces the temperatures in the logs by those of a unit that follows the air (ThermalNodes), notes what was done in
/// `campaign.fine_temperature`, and takes the steps out of `campaign.thermometer`. Their error is judged where the
/// reading goes from one step to the next while the temperature moves slowly: there it is known. Leaves the campaign as
/// it is where that error is above 0.1 K or such moments are too few, where the air was logged in steps too or not
/// throughout, where sensors have thermometers of their own, and where a run has no plateaus. Cost:
/// fit_thermal_nodes().
void refine_logs(LoggedCampaign& campaign);

/// Gives the blocks of all segments the temperatures of refined logs; nothing to do for other campaigns.
void refine_blocks(LoggedCampaign& campaign);

}  // namespace soak::calib::gap
