// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace soak::station {

/// Unix time at which the UTC day "2027-03-01" begins; nothing for a text that is no day of the years 1970 to 9999.
[[nodiscard]] std::optional<double> parse_iso_date(std::string_view text);

/// The UTC day of a Unix time: "2027-03-01"; outside the years 1970 to 9999 the number of seconds.
[[nodiscard]] std::string iso_date(double utc_s);

}  // namespace soak::station
