// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "nav/drive/drive.h"

namespace soak::station {

/// The recording that a drive file (TOML, docs/nav.md) describes: readings as CSV, fixes and truth as RTKLIB solutions
/// or CSV. Paths in it are relative to its folder. Refuses (bad_input) what is wrong in the file, with all its lines;
/// in a recording the first row that is wrong, with its line; and what nav::validate() refuses.
[[nodiscard]] base::Result<nav::Drive> read_drive(const std::string& path);

}  // namespace soak::station
