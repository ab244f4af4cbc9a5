// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// The bytes of a text file. Refuses what cannot be read, and UTF-16, binary and classic-Mac files, with the remedy.
[[nodiscard]] base::Result<std::string> read_text_file(const std::filesystem::path& path);

/// Writes the file anew: to a temporary name beside it, synced, then renamed, and the name synced. On failure no
/// temporary file is left behind.
/// Follows symbolic links; writes into a device or pipe without replacing it.
[[nodiscard]] base::Status write_text_file(const std::filesystem::path& path, std::string_view text);

/// Whether write_text_file() could begin, for those whose text takes long to make: fails as it does, and leaves all as
/// it was.
[[nodiscard]] base::Status check_writable(const std::filesystem::path& path);

}  // namespace soak::station
