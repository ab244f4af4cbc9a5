// SPDX-License-Identifier: Apache-2.0
#include "station/io/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "db/durable.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

/// Never takes the place of another file; the error number. Folders on memory cards know no hard links, those of some
/// servers no such rename: one of the two works.
int give_new_name(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  if (::link(from.c_str(), to.c_str()) != 0) return errno;
  ::unlink(from.c_str());
  return 0;
}

}  // namespace

base::Result<bool> write_new_text_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path partial = path.string() + ".new";
  if (auto written = write_text_file(partial, text); !written) return base::forward_error(written);
  const int error = give_new_name(partial, path);
  if (error != 0) ::unlink(partial.c_str());
  if (error == EEXIST) return false;
  if (error != 0) {
    return base::fail(base::ErrorKind::internal, "cannot write: " + std::generic_category().message(error),
                      path.string());
  }
  if (auto synced = db::sync_name(path); !synced) return base::forward_error(synced);
  return true;
}

}  // namespace soak::station
