// SPDX-License-Identifier: Apache-2.0
#include "station/io/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>

namespace soak::station {
namespace {

std::string holder_of(int fd) {
  std::array<char, 32> text{};
  const ssize_t read = ::pread(fd, text.data(), text.size() - 1, 0);
  return read > 0 ? std::string(text.data()) : "unknown";
}

}  // namespace

base::Result<FolderLock> FolderLock::take(const std::filesystem::path& file, std::string_view what) {
  FolderLock lock(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (lock.fd_ < 0) {
    return base::bad_input("cannot write here: " + std::generic_category().message(errno), file.string());
  }
  if (::flock(lock.fd_, LOCK_EX | LOCK_NB) != 0) {
    return base::bad_input(
        fmt::format("another {} (process {}) works on this data folder: stop it, or name another folder with --data",
                    what, holder_of(lock.fd_)),
        file.parent_path().string());
  }
  const std::string process = fmt::format("{}", ::getpid());
  if (::ftruncate(lock.fd_, 0) != 0 ||
      ::pwrite(lock.fd_, process.data(), process.size(), 0) != static_cast<ssize_t>(process.size())) {
    return base::bad_input("cannot write here: " + std::generic_category().message(errno), file.string());
  }
  return lock;
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

}  // namespace soak::station
