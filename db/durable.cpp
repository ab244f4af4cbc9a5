// SPDX-License-Identifier: Apache-2.0
#include "db/durable.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/file_descriptor.h"

namespace soak::db {
namespace {

tl::unexpected<base::Error> cannot(std::string_view doing, std::string_view reason, const std::filesystem::path& path) {
  return base::fail(base::ErrorKind::internal,
                    std::string("cannot ").append(doing).append(": ").append(reason).append("; check the disk"),
                    path.string());
}

/// The folders that are missing on the way to `folder`, the outermost first.
std::vector<std::filesystem::path> missing_folders(std::filesystem::path folder) {
  std::vector<std::filesystem::path> missing;
  std::error_code ignored;
  while (!folder.empty() && !std::filesystem::exists(folder, ignored)) {
    missing.insert(missing.begin(), folder);
    folder = folder.parent_path();
  }
  return missing;
}

}  // namespace

base::Status sync_to_disk(const std::filesystem::path& path) {
  const base::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file && ::fsync(file.get()) == 0) return {};
  return cannot("sync to the disk", std::generic_category().message(errno), path);
}

base::Status sync_name(const std::filesystem::path& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  const base::FileDescriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor && ::fsync(descriptor.get()) == 0) return {};
  // Some file systems sync no folders, and a folder may be writable but not readable: the file is there all the same.
  if (errno == EINVAL || errno == ENOTSUP || errno == EACCES) return {};
  return cannot("sync to the disk", std::generic_category().message(errno), folder);
}

base::Status rename_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  // Contents first: a name must never lead to a file that is not whole.
  if (auto whole = sync_to_disk(from); !whole) return whole;
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) return cannot("rename the file", error.message(), to);
  return sync_name(to);
}

base::Status create_folders_durably(const std::filesystem::path& folder) {
  for (const std::filesystem::path& path : missing_folders(std::filesystem::absolute(folder).lexically_normal())) {
    std::error_code error;
    std::filesystem::create_directory(path, error);
    if (error) return cannot("create the folder", error.message(), path);
    if (auto named = sync_name(path); !named) return named;
  }
  return {};
}

}  // namespace soak::db
