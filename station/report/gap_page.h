// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "station/gap/gap_comparison.h"

namespace soak::station {

/// The gap before and after as one HTML page that needs nothing else: per sensor what was read beyond the simulation,
/// over temperature, with a table of figures and what was accepted. `software`: name and version of this program.
[[nodiscard]] std::string gap_page(const GapComparison& comparison, const std::string& software, double created_utc_s);

}  // namespace soak::station
