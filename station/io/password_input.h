// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"

namespace soak::station {

/// A password from the person at the terminal, who does not see it and types it twice; where standard input is no
/// terminal, its first line. Never from the command line, which other users of the machine can read. Refuses
/// (bad_input) two that differ, and an input that ends before the line does.
[[nodiscard]] base::Result<std::string> read_password(const std::string& prompt);

}  // namespace soak::station
