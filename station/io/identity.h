// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace soak::station {

/// The host's clock, Unix time.
[[nodiscard]] double now_utc_s();

/// A new UUIDv7 from the host's clock and its source of randomness.
[[nodiscard]] std::string new_run_id();

/// Name of the user that runs the program: what $USER says, else the account's, else "unknown".
[[nodiscard]] std::string user_name();

}  // namespace soak::station
