// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/result.h"

/// Names and contents of files that survive a loss of power. A file system may keep a new name in memory long after the
/// contents of the file are on the disk, and the other way round; what is written here is forced there in order.
namespace soak::db {

/// Forces contents and size of a file, or the names in a folder, to the disk (fsync). Fails (internal) with the reason.
[[nodiscard]] base::Status sync_to_disk(const std::filesystem::path& path);

/// Forces the names in the folder that holds `path` to the disk, as far as its file system does that for folders (some
/// network and shared file systems do not). Fails (internal) where the disk does.
[[nodiscard]] base::Status sync_name(const std::filesystem::path& path);

/// Gives a file another name in the same file system, replacing what has that name, and forces contents and name to the
/// disk: after success a loss of power leaves the file whole under its new name. Fails (internal); the file then has
/// either name.
[[nodiscard]] base::Status rename_durably(const std::filesystem::path& from, const std::filesystem::path& to);

/// Creates a folder with the parents that are missing, their names forced to the disk. Fails (internal).
[[nodiscard]] base::Status create_folders_durably(const std::filesystem::path& folder);

}  // namespace soak::db
