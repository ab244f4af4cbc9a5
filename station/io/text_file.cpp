// SPDX-License-Identifier: Apache-2.0
#include "station/io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <system_error>

#include "base/file_descriptor.h"
#include "db/durable.h"

namespace soak::station {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

base::Status check_text(std::string_view text, const std::string& where) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    return base::bad_input("the file is UTF-16 text: save it as UTF-8", where);
  }
  if (text.find('\0') != std::string_view::npos) {
    return base::bad_input("the file contains zero bytes and is not text: give a text file in UTF-8", where);
  }
  const std::size_t carriage_return = text.find('\r');
  if (carriage_return != std::string_view::npos && text.find('\n') == std::string_view::npos) {
    return base::bad_input("the lines end with CR alone: save the file with LF or CRLF line ends", where);
  }
  return {};
}

/// Refuses to replace what nothing can bring back: a catalog or a run file, a secret key.
base::Status check_replaceable(const std::filesystem::path& path) {
  constexpr std::string_view kDatabase{"SQLite format 3\0", 16};
  constexpr std::string_view kSecretKey = "soak-secret-key-";
  static_assert(kDatabase.size() == kSecretKey.size());
  std::array<char, kDatabase.size()> head{};
  const base::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file || ::read(file.get(), head.data(), head.size()) != static_cast<ssize_t>(head.size())) return {};
  const std::string_view found(head.data(), head.size());
  if (found != kDatabase && found != kSecretKey) return {};
  return base::bad_input(fmt::format("the existing file is a {} and is never replaced: give another name",
                                     found == kDatabase ? "database (a catalog or a run file)" : "secret key"),
                         path.string());
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

base::Status cannot_write(int error, const std::filesystem::path& path) {
  return base::bad_input("cannot write: " + reason(error), path.string());
}

base::Status write_into(const std::filesystem::path& path, std::string_view text) {
  const base::FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file) return cannot_write(errno, path);
  if (write_all(file.get(), text)) return {};
  return base::fail(base::ErrorKind::internal, "cannot write: " + reason(errno), path.string());
}

std::filesystem::path target_of(const std::filesystem::path& given) {
  std::error_code ignored;
  const std::filesystem::path target = std::filesystem::weakly_canonical(given, ignored);
  return target.empty() ? given : target;
}

/// A device or a pipe is written to, never replaced.
bool is_replaced(const std::filesystem::path& path) {
  std::error_code ignored;
  return !std::filesystem::exists(path, ignored) || std::filesystem::is_regular_file(path, ignored);
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  return path.string() + ".tmp" + std::to_string(::getpid());
}

base::FileDescriptor created(const std::filesystem::path& temporary) {
  return base::FileDescriptor(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
}

base::Status cannot_create(int error, const std::filesystem::path& path) {
  return base::bad_input("cannot create the file: " + reason(error), path.string());
}

}  // namespace

base::Result<std::string> read_text_file(const std::filesystem::path& path) {
  const std::string where = path.string();
  const base::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return base::bad_input("cannot open the file: " + reason(errno), where);
  struct stat status{};
  if (::fstat(file.get(), &status) == 0 && S_ISDIR(status.st_mode)) {
    return base::bad_input("is a folder, not a file", where);
  }
  std::string text(status.st_size > 0 ? static_cast<std::size_t>(status.st_size) : 0, '\0');
  std::size_t size = 0;
  while (true) {
    if (size == text.size()) text.resize(size + 65536);
    const ssize_t count = ::read(file.get(), text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return base::bad_input("cannot read the file: " + reason(errno), where);
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  text.resize(size);
  if (const auto status_of_text = check_text(text, where); !status_of_text) return base::forward_error(status_of_text);
  return text;
}

base::Status check_writable(const std::filesystem::path& given) {
  const std::filesystem::path path = target_of(given);
  if (!is_replaced(path)) {
    std::error_code ignored;
    const bool is_folder = std::filesystem::is_directory(path, ignored);
    if (!is_folder && ::access(path.c_str(), W_OK) == 0) return {};
    return cannot_write(is_folder ? EISDIR : errno, path);
  }
  if (auto replaceable = check_replaceable(path); !replaceable) return replaceable;
  const std::filesystem::path temporary = temporary_beside(path);
  if (!created(temporary)) return cannot_create(errno, path);
  ::unlink(temporary.c_str());
  return {};
}

base::Status write_text_file(const std::filesystem::path& given, std::string_view text) {
  const std::filesystem::path path = target_of(given);
  if (!is_replaced(path)) return write_into(path, text);
  if (auto replaceable = check_replaceable(path); !replaceable) return replaceable;
  const std::filesystem::path temporary = temporary_beside(path);
  int error = 0;
  {
    const base::FileDescriptor file = created(temporary);
    if (!file) return cannot_create(errno, path);
    if (!write_all(file.get(), text)) error = errno;
  }
  base::Status written;
  if (error == 0) {
    written = db::rename_durably(temporary, path);
  } else {
    written = base::fail(base::ErrorKind::internal, "cannot write the file: " + reason(error), path.string());
  }
  if (!written) ::unlink(temporary.c_str());
  return written;
}

}  // namespace soak::station
