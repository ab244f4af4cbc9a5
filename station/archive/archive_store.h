// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "base/result.h"

/// Where an archive lies: files that are written once and never changed, known by their names.
namespace soak::station {

/// A place that holds files.
class ArchiveStore {
 public:
  virtual ~ArchiveStore() = default;
  ArchiveStore(const ArchiveStore&) = delete;
  ArchiveStore& operator=(const ArchiveStore&) = delete;

  /// As the user named it.
  [[nodiscard]] virtual std::string place() const = 0;
  /// Where a file of that name lies on this machine; nothing for a remote.
  [[nodiscard]] virtual std::optional<std::filesystem::path> local_path(const std::string& name) const = 0;
  /// Names of the files in one of its folders that are named by a SHA-256, and of no others; none where the folder is
  /// not there. Fails (internal) where it cannot be read.
  [[nodiscard]] virtual base::Result<std::set<std::string>> list(const std::string& folder) const = 0;
  /// Copies a file into the archive, where it has its name only once it is whole. Fails (internal), also where what
  /// arrived does not have that SHA-256 (of a remote: where rclone sees that).
  [[nodiscard]] virtual base::Status put(const std::filesystem::path& file, const std::string& name,
                                         const std::string& sha256) = 0;
  /// Copies a file out of the archive, replacing `file`. What it holds is the caller's to check. Fails (internal).
  [[nodiscard]] virtual base::Status get(const std::string& name, const std::filesystem::path& file) const = 0;

 protected:
  ArchiveStore() = default;
};

/// SHA-256 of a file in hexadecimal. Fails (internal) where it cannot be read.
[[nodiscard]] base::Result<std::string> file_sha256(const std::filesystem::path& file);

/// A folder, or what rclone reaches under a name with a colon before any slash ("s3:soak/archive"; its own
/// configuration says how). Refuses (bad_input) a remote where rclone is not installed.
[[nodiscard]] base::Result<std::unique_ptr<ArchiveStore>> archive_store(const std::string& place);

}  // namespace soak::station
