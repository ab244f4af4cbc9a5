// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// Keeps a second process of the same kind out of a folder. The operating system lets go of it when the process ends,
/// however that happens; the file itself stays.
class FolderLock {
 public:
  /// Takes the lock of `file`, made where it is missing; refuses (bad_input) where another process holds it, and names
  /// that process. `what` is the program's name for the message.
  [[nodiscard]] static base::Result<FolderLock> take(const std::filesystem::path& file, std::string_view what);
  FolderLock(FolderLock&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace soak::station
