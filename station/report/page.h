// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace soak::station {

/// A unit's report as one HTML page that needs nothing else: no script, no font, no picture from elsewhere; a content
/// security policy forbids them. Texts of the document are escaped. Numbers stand in `<data value="...">` with all
/// their digits. `document` is that of report_document().
[[nodiscard]] std::string report_page(const nlohmann::json& document);

}  // namespace soak::station
