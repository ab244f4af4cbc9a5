// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"

namespace soak::hal::sim {

/// Makes a folder, and those above it, where it is missing. Error: bad_input.
[[nodiscard]] base::Status make_folder(const std::filesystem::path& folder);

/// Writes or replaces a file. Error: internal.
[[nodiscard]] base::Status write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace soak::hal::sim
