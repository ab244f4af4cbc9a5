// SPDX-License-Identifier: Apache-2.0
#include "db/detail/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "base/bytes.h"
#include "base/hash.h"

namespace soak::db::sqlite {
namespace {

/// Closes a file descriptor at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  [[nodiscard]] int value() const { return value_; }
  [[nodiscard]] bool valid() const { return value_ >= 0; }

 private:
  int value_;
};

base::Error system_error(std::string_view doing, const std::filesystem::path& path) {
  std::string message = std::string("cannot ").append(doing).append(": ").append(std::strerror(errno));
  return {base::ErrorKind::internal, std::move(message), path.string()};
}

}  // namespace

base::Status create_exclusively(const std::filesystem::path& path) {
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (file.valid()) return {};
  if (errno == EEXIST) return base::bad_input("the file exists already; give a path that is free", path.string());
  return tl::unexpected<base::Error>(system_error("create the file", path));
}

base::Status sync_to_disk(const std::filesystem::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.valid() && ::fsync(file.value()) == 0) return {};
  return tl::unexpected<base::Error>(system_error("sync to the disk", path));
}

void remove_with_companions(const std::filesystem::path& path) {
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    std::error_code ignored;
    std::filesystem::remove(std::filesystem::path(path) += suffix, ignored);
  }
}

base::Result<std::string> sha256_of_file(const std::filesystem::path& path) {
  constexpr std::size_t kBlockSize = std::size_t{1} << 20;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(kBlockSize);
  base::Sha256 hash;
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.update(std::string_view(block.data(), static_cast<std::size_t>(file.gcount())));
  }
  if (!file.eof()) return tl::unexpected<base::Error>(system_error("read the file", path));
  return base::to_hex(hash.finish());
}

}  // namespace soak::db::sqlite
