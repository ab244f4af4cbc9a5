// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/campaign/campaign.h"
#include "calib/vocabulary/recording.h"

namespace soak::calib::gap {

/// Bins of 10 s, or of the median distance between rows where that is longer; bins without a row are left out.
/// Auxiliary channels by name: chamber_c, compressor, supply_v. Where the recording does not know the time since
/// power-on, its first row is at power-on. Cost linear in rows.
[[nodiscard]] RunLog make_run_log(const Recording& recording);

}  // namespace soak::calib::gap
