// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"

/// Files below SQLite: creation, syncing, hashing.
namespace soak::db::sqlite {

/// Creates an empty file; refuses a path that exists (bad_input).
[[nodiscard]] base::Status create_exclusively(const std::filesystem::path& path);

/// Forces contents and size of a file, or the names in a folder, to the disk (fsync).
[[nodiscard]] base::Status sync_to_disk(const std::filesystem::path& path);

/// Removes a SQLite file with its -wal, -shm and -journal.
void remove_with_companions(const std::filesystem::path& path);

/// SHA-256 of the file's bytes in hexadecimal.
[[nodiscard]] base::Result<std::string> sha256_of_file(const std::filesystem::path& path);

}  // namespace soak::db::sqlite
