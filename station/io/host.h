// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// What only the computer knows: the time, its user, chance; and the daemon's log.
namespace soak::station {

/// The host's clock, Unix time.
[[nodiscard]] double now_utc_s();

/// A new UUIDv7 from the host's clock and its source of randomness.
[[nodiscard]] std::string new_run_id();

/// `stated`, else the name of the user that runs the program: what $USER says, else the account's, else "unknown".
[[nodiscard]] std::string user_name(const std::string& stated = {});

/// Version of the programs: "0.2.0".
[[nodiscard]] std::string software_version();

/// One line of the daemon's own log on standard error, with date and time unless that is systemd's journal.
void log_line(const std::string& text);

}  // namespace soak::station
