// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// Writes a text file that is not there yet, synced, all of it or nothing. False where there is a file of that name,
/// also one that appeared just now, of whatever kind: it stays as it is. Not for two that write the same name at once.
[[nodiscard]] base::Result<bool> write_new_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace soak::station
