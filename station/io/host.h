// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

/// What only the computer knows: the time, its user, chance, the program's memory; and the daemon's log.
namespace soak::station {

/// The host's clock, Unix time.
[[nodiscard]] double now_utc_s();

/// A new UUIDv7 from the host's clock and its source of randomness.
[[nodiscard]] std::string new_run_id();

/// `stated`, else the name of the user that runs the program: what $USER says, else the account's, else "unknown".
[[nodiscard]] std::string user_name(const std::string& stated = {});

/// Version of the programs: "0.2.0".
[[nodiscard]] std::string software_version();

/// Makes all threads share one heap. To be called before there is a second thread, by a program that works for weeks.
void share_one_heap();

/// What the program has allocated and not given back, large blocks included; not what the heap holds free for it.
[[nodiscard]] std::size_t heap_in_use_bytes();

/// One line of the daemon's own log on standard error, with date and time unless that is systemd's journal.
void log_line(const std::string& text);

}  // namespace soak::station
