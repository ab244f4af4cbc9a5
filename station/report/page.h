// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "station/gap/gap_comparison.h"

namespace soak::station {

/// A unit's report as one HTML page that needs nothing else: no script, no font, no picture from elsewhere; a content
/// security policy forbids them. Its figures are drawn by its own script from data in it. Texts of the document are
/// escaped. Numbers stand in `<data value="...">` with all their digits. `document` is that of report_document().
[[nodiscard]] std::string report_page(const nlohmann::json& document);

/// The gap before and after as one HTML page that needs nothing else: per sensor what was read beyond the simulation,
/// over temperature, with a table of figures and what was accepted. `software`: name and version of this program.
[[nodiscard]] std::string gap_page(const GapComparison& comparison, const std::string& software, double created_utc_s);

}  // namespace soak::station
