// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::station {

/// The style sheet of a report: light and dark, narrow screens, A4. Colours are those of the station's pages (web/).
[[nodiscard]] std::string_view report_style();

}  // namespace soak::station
