// SPDX-License-Identifier: Apache-2.0
#include "db/detail/sqlite.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/file_descriptor.h"
#include "base/hash.h"

namespace soak::db::sqlite {
namespace {

/// Longest text or blob that one of our files holds; refuses hostile sizes before memory is taken.
constexpr int kMaxLength = 64 * 1024 * 1024;

/// `file:` URI of a path: all that is not plainly safe is percent-encoded.
std::string uri_of(const std::filesystem::path& path, std::string_view query) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
                       c == '.' || c == '_' || c == '-';
    if (plain) {
      uri += c;
    } else {
      uri.append({'%', kHex[byte >> 4], kHex[byte & 15U]});
    }
  }
  return uri.append(query);
}

/// The first bytes of a file, as many as there are; nothing where they cannot be read. They are read by way of SQLite's
/// own files: POSIX locks are those of a process, and whoever opens and closes a file beside SQLite takes them from all
/// connections that the process has to it. Then the last other program that closes the file takes its -wal away from
/// under them, with all that is committed there from then on.
std::optional<std::size_t> read_beginning(const std::filesystem::path& path, std::array<char, 100>& bytes) {
  sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
  std::vector<std::max_align_t> memory(static_cast<std::size_t>(vfs->szOsFile) / sizeof(std::max_align_t) + 1);
  auto* const file = reinterpret_cast<sqlite3_file*>(memory.data());
  const std::string name = std::filesystem::absolute(path).string();
  if (vfs->xOpen(vfs, name.c_str(), file, SQLITE_OPEN_READONLY | SQLITE_OPEN_MAIN_DB, nullptr) != SQLITE_OK) {
    return std::nullopt;
  }
  // Not SQLite's word for the size: it calls a file of one byte empty.
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  const auto count = error ? 0 : static_cast<std::size_t>(std::min<std::uintmax_t>(size, bytes.size()));
  int code = error ? SQLITE_IOERR : SQLITE_OK;
  if (count > 0) code = file->pMethods->xRead(file, bytes.data(), static_cast<int>(count), 0);
  file->pMethods->xClose(file);
  return code == SQLITE_OK ? std::optional(count) : std::nullopt;
}

std::uint64_t big_endian_at(const std::array<char, 100>& header, std::size_t offset, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < size; ++i) number = (number << 8) | static_cast<unsigned char>(header[offset + i]);
  return number;
}

bool is_disk_full(const SQLite::Exception& exception, int system_errno) {
  const int code = exception.getErrorCode() & 0xFF;
  if (code == SQLITE_FULL) return true;
  if (code != SQLITE_IOERR) return false;
  // A write that stops short without an error of its own has met the end of the space, too.
  if (system_errno == 0) return exception.getExtendedErrorCode() == SQLITE_IOERR_WRITE;
  return system_errno == ENOSPC || system_errno == EDQUOT || system_errno == EFBIG;
}

/// Why, and what helps, for the codes that say something about the world or the file.
std::optional<std::string> cause_of(const SQLite::Exception& exception, int system_errno) {
  if (is_disk_full(exception, system_errno)) {
    return "the disk is full or the file may not grow; free some space and try again: nothing of this step was stored";
  }
  if (exception.getExtendedErrorCode() == SQLITE_READONLY_DBMOVED) {
    return "the file was moved or deleted while it was open; put it back where it was";
  }
  switch (exception.getErrorCode() & 0xFF) {
    case SQLITE_READONLY:
      return "file or folder is read-only; make both writable or use another data folder";
    case SQLITE_CANTOPEN:
      return "file or folder cannot be opened; check that it exists and may be read and written";
    case SQLITE_PERM:
      return "access is not permitted; check owner and mode of file and folder";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another process keeps the file locked; end it or wait for it, then try again";
    case SQLITE_IOERR:
      return std::string("input/output error (") + std::strerror(system_errno) + "); check the disk";
    case SQLITE_CORRUPT:
      return "the file is damaged; restore it from a backup";
    case SQLITE_NOTADB:
      return "the file is damaged or not a SQLite file; restore it from a backup";
    default:
      return std::nullopt;
  }
}

base::Status configure(SQLite::Database& database, const std::filesystem::path& path, Access access) {
  sqlite3* const handle = database.getHandle();
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kMaxLength);
  // The schema of a file from elsewhere is text that nobody vouches for: it may not call functions with effects.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (access != Access::read_write) return {};
  if (sqlite3_db_readonly(handle, "main") == 1) {
    return base::fail(base::ErrorKind::internal, "the file is read-only; make file and folder writable", path.string());
  }
  database.exec("PRAGMA foreign_keys = ON");
  return {};
}

/// SQLite's own lock, which each value that is read would take and leave, is not needed: a connection has one thread at
/// a time. A strip chart reads some hundred thousand values.
int flags_of(Access access) {
  if (access == Access::read_write) return SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_NOMUTEX;
  return SQLite::OPEN_READONLY | SQLite::OPEN_URI | SQLite::OPEN_NOMUTEX;
}

base::Error system_error(std::string_view doing, const std::filesystem::path& path) {
  std::string message = std::string("cannot ").append(doing).append(": ").append(std::strerror(errno));
  return {base::ErrorKind::internal, std::move(message), path.string()};
}

}  // namespace

base::Result<Header> read_header(const std::filesystem::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return Header{};
  std::array<char, 100> bytes{};
  const auto count = read_beginning(path, bytes);
  if (!count) {
    return base::fail(base::ErrorKind::internal, "the file cannot be opened for reading; check owner and mode",
                      path.string());
  }
  if (*count == 0) return Header{};
  if (*count < bytes.size() || std::string_view(bytes.data(), kMagic.size()) != kMagic) {
    return base::corrupt("the file is damaged or not a SQLite file; restore it from a backup", path.string());
  }
  Header header;
  header.empty = false;
  // Offsets: sqlite.org/fileformat2.html §1.3.
  header.wal = bytes[19] == 2;
  const std::uint64_t page_size = big_endian_at(bytes, 16, 2);
  header.identity.user_version = static_cast<std::uint32_t>(big_endian_at(bytes, 60, 4));
  header.identity.application_id = static_cast<std::uint32_t>(big_endian_at(bytes, 68, 4));
  header.stated_size = (page_size == 1 ? 65536 : page_size) * big_endian_at(bytes, 28, 4);
  return header;
}

base::Error error_of(const SQLite::Exception& exception, int system_errno, const std::filesystem::path& path,
                     std::string_view doing) {
  const int code = exception.getErrorCode() & 0xFF;
  const bool damaged = code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
  const bool refused = code == SQLITE_CONSTRAINT;
  base::Error error;
  error.kind = damaged ? base::ErrorKind::corrupt : refused ? base::ErrorKind::bad_input : base::ErrorKind::internal;
  error.message = std::string("cannot ").append(doing).append(": ");
  error.message += cause_of(exception, system_errno).value_or(exception.what());
  error.where = path.string();
  return error;
}

Connection::Connection(std::filesystem::path path, std::unique_ptr<SQLite::Database> database)
    : path_(std::move(path)), database_(std::move(database)) {}

base::Result<Connection> Connection::open(const std::filesystem::path& path, Access access) {
  const std::string name = access == Access::read_write  ? path.string()
                           : access == Access::immutable ? uri_of(path, "?immutable=1")
                                                         : uri_of(path, "");
  try {
    auto database = std::make_unique<SQLite::Database>(name, flags_of(access), kBusyTimeoutMs);
    if (const auto configured = configure(*database, path, access); !configured) {
      return base::forward_error(configured);
    }
    return Connection(path, std::move(database));
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected<base::Error>(error_of(exception, errno, path, "open the file"));
  }
}

int Connection::system_errno() const { return sqlite3_system_errno(database_->getHandle()); }

bool Connection::in_transaction() const { return sqlite3_get_autocommit(database_->getHandle()) == 0; }

base::Result<Identity> Connection::identity() const {
  return run("read the file", [&]() -> base::Result<Identity> {
    Identity identity;
    identity.application_id = database_->execAndGet("PRAGMA application_id").getUInt();
    identity.user_version = database_->execAndGet("PRAGMA user_version").getUInt();
    return identity;
  });
}

base::Status Connection::integrity_check() const {
  return run("check the file", [&]() -> base::Status {
    SQLite::Statement check(*database_, "PRAGMA integrity_check(1)");
    if (!check.executeStep()) return base::corrupt("the integrity check gives no answer", path_.string());
    const std::string finding = check.getColumn(0).getString();
    if (finding != "ok") {
      return base::corrupt("the file is damaged (" + finding + "); restore it from a backup", path_.string());
    }
    return {};
  });
}

base::Status create_exclusively(const std::filesystem::path& path) {
  const base::FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (file) return {};
  if (errno == EEXIST) return base::bad_input("the file already exists; choose another path", path.string());
  return tl::unexpected<base::Error>(system_error("create the file", path));
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
