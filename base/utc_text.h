// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace soak::calib::file {

/// Unix time as "2026-11-21T08:00:00Z" (Gregorian calendar, leap seconds not counted, fractions cut); for times outside
/// the years 1970 to 9999 the number of seconds.
[[nodiscard]] std::string utc_text(double unix_s);

}  // namespace soak::calib::file
