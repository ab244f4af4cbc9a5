// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/gap/ramps/detail/ramp_mechanisms.h"
#include "calib/gap/search/outside_the_mean.h"

namespace soak::calib::gap::reduced {

/// Effects that one attitude without plateaus cannot show, each with why: those that need positions, plateaus or runs,
/// and those whose channel was not recorded.
[[nodiscard]] std::vector<NotTestable> not_testable_by_branches(const std::vector<Mechanism>& tried);

}  // namespace soak::calib::gap::reduced
