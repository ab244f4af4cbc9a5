// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Transaction.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/result.h"

/// SQLite behind results: exceptions of the library end here.
namespace soak::db::sqlite {

/// How long a statement waits for another process.
inline constexpr int kBusyTimeoutMs = 10'000;

enum class Access {
  read_write,  ///< creates the file where absent
  read_only,   ///< sees what others write meanwhile; may create the -shm file of a file in WAL mode
  immutable,   ///< takes no locks and creates no files: only for files that nobody writes
};

/// What the first bytes of a file say.
struct Header {
  bool empty = true;              ///< no file, or a file of no bytes
  bool wal = false;               ///< in WAL mode: the rest of the header may be older than what the -wal file holds
  std::uint64_t stated_size = 0;  ///< bytes that the file should have
};

/// What kind of file it is, as its newest transaction says.
struct Identity {
  std::uint32_t application_id = 0;
  std::uint32_t user_version = 0;
};

/// Reads the header without SQLite; corrupt if the file is no SQLite file.
[[nodiscard]] base::Result<Header> read_header(const std::filesystem::path& path);

/// The user's view of an exception: what could not be done with which file, why, and what would help. Damaged files are
/// `corrupt`; everything about the world (full disk, read-only folder, locks) is `internal`.
[[nodiscard]] base::Error error_of(const SQLite::Exception& exception, int system_errno,
                                   const std::filesystem::path& path, std::string_view doing);

/// One connection to one file. One thread at a time.
class Connection {
 public:
  [[nodiscard]] static base::Result<Connection> open(const std::filesystem::path& path, Access access);

  [[nodiscard]] SQLite::Database& database() const { return *database_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Runs `work`, which returns a result, and turns an exception of SQLite into an error. `doing` completes "cannot
  /// ...".
  template <class Work>
  std::invoke_result_t<Work&> run(std::string_view doing, Work&& work) const {
    try {
      return std::invoke(work);
    } catch (const SQLite::Exception& exception) {
      return tl::unexpected<base::Error>(error_of(exception, system_errno(), path_, doing));
    }
  }

  /// Runs `work` inside an IMMEDIATE transaction: committed if it succeeds, else rolled back. Inside another one,
  /// `work` is part of that.
  template <class Work>
  std::invoke_result_t<Work&> transact(std::string_view doing, Work&& work) const {
    return run(doing, [&]() -> std::invoke_result_t<Work&> {
      if (in_transaction()) return std::invoke(work);
      SQLite::Transaction transaction(*database_, SQLite::TransactionBehavior::IMMEDIATE);
      auto result = std::invoke(work);
      if (result) transaction.commit();
      return result;
    });
  }

  [[nodiscard]] base::Result<Identity> identity() const;

  /// SQLite's own check of the whole file: corrupt with its first finding, if any.
  [[nodiscard]] base::Status integrity_check() const;

 private:
  Connection(std::filesystem::path path, std::unique_ptr<SQLite::Database> database);
  [[nodiscard]] int system_errno() const;
  [[nodiscard]] bool in_transaction() const;

  std::filesystem::path path_;
  std::unique_ptr<SQLite::Database> database_;
};

}  // namespace soak::db::sqlite
