// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace soak::station {

/// One line of the daemon's own log on standard error, with date and time.
void log_line(const std::string& text);

}  // namespace soak::station
