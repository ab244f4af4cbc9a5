// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

/// SQLite behind results: exceptions of the library end here. Below it: creation, syncing and hashing of files.
namespace soak::db::sqlite {

/// How long a statement waits for another process.
inline constexpr int kBusyTimeoutMs = 10'000;

enum class Access {
  read_write,  ///< creates the file where absent
  read_only,   ///< sees what others write meanwhile; may create the -shm file of a file in WAL mode
  immutable,   ///< takes no locks and creates no files: only for files that nobody writes
};

/// What kind of file it is.
struct Identity {
  std::uint32_t application_id = 0;
  std::uint32_t user_version = 0;
};

/// What the first bytes of a file say.
struct Header {
  bool empty = true;              ///< no file, or a file of no bytes
  bool wal = false;               ///< in WAL mode: the rest of the header may be older than what the -wal file holds
  std::uint64_t stated_size = 0;  ///< bytes that the file should have
  Identity identity;
};

/// Reads the header without a connection; corrupt if the file is no SQLite file. Connections that this process has to
/// the file keep their locks.
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

  /// As the newest transaction says.
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

// ---- Values in and out of statements, in the order of their columns. SQLite has no NaN: it is stored as NULL.

/// Binds the parameters of a statement one after the other.
class Binder {
 public:
  explicit Binder(SQLite::Statement& statement) : statement_(statement) {}

  Binder& add(std::string_view text) {
    statement_.bind(next_++, std::string(text));
    return *this;
  }
  Binder& add(double value) {
    statement_.bind(next_++, value);
    return *this;
  }
  template <std::integral T>
  Binder& add(T value) {
    statement_.bind(next_++, static_cast<std::int64_t>(value));
    return *this;
  }
  /// `bytes` must live until the statement has run.
  Binder& add(const base::Bytes& bytes) {
    // A null pointer would bind NULL instead of the blob of no bytes.
    static constexpr std::uint8_t kNothing = 0;
    statement_.bindNoCopy(next_++, bytes.empty() ? &kNothing : bytes.data(), static_cast<int>(bytes.size()));
    return *this;
  }
  Binder& add_null() {
    statement_.bind(next_++);
    return *this;
  }
  template <class T>
  Binder& add(const std::optional<T>& value) {
    return value ? add(*value) : add_null();
  }

 private:
  SQLite::Statement& statement_;
  int next_ = 1;
};

/// Binds all of `values` in order.
template <class... Values>
void bind_all(SQLite::Statement& statement, const Values&... values) {
  Binder binder(statement);
  (binder.add(values), ...);
}

/// Reads the columns of the current row one after the other.
class Fields {
 public:
  explicit Fields(SQLite::Statement& statement) : statement_(statement) {}

  std::string text() { return next().getString(); }
  std::int64_t integer() { return next().getInt64(); }
  std::int32_t integer32() { return static_cast<std::int32_t>(next().getInt64()); }
  bool flag() { return next().getInt64() != 0; }

  /// NaN for NULL.
  double real() {
    const SQLite::Column column = next();
    return column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
  }
  std::optional<double> optional_real() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(column.getDouble());
  }
  std::optional<std::int32_t> optional_integer() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(static_cast<std::int32_t>(column.getInt64()));
  }
  std::optional<std::string> optional_text() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(column.getString());
  }
  /// No bytes for NULL; valid until the statement goes on.
  std::span<const std::uint8_t> blob() {
    const SQLite::Column column = next();
    const auto* first = static_cast<const std::uint8_t*>(column.getBlob());
    if (first == nullptr) return {};
    return {first, static_cast<std::size_t>(column.getBytes())};
  }

 private:
  SQLite::Column next() { return statement_.getColumn(next_++); }

  SQLite::Statement& statement_;
  int next_ = 0;
};

/// Runs a statement that gives no rows, with `values` for its parameters. Throws SQLite::Exception.
template <class... Values>
void execute(const SQLite::Database& database, const std::string& sql, const Values&... values) {
  SQLite::Statement statement(database, sql);
  bind_all(statement, values...);
  statement.exec();
}

/// Whether a query has a row. Throws SQLite::Exception.
template <class... Values>
[[nodiscard]] bool has_row(const SQLite::Database& database, const std::string& sql, const Values&... values) {
  SQLite::Statement query(database, sql);
  bind_all(query, values...);
  return query.executeStep();
}

/// What `read`, which is given Fields, makes of each row of a query. Throws SQLite::Exception.
template <class Read, class... Values>
[[nodiscard]] auto rows_of(const SQLite::Database& database, const std::string& sql, const Read& read,
                           const Values&... values) {
  SQLite::Statement query(database, sql);
  bind_all(query, values...);
  std::vector<std::invoke_result_t<const Read&, Fields&>> rows;
  while (query.executeStep()) {
    Fields fields(query);
    rows.push_back(read(fields));
  }
  return rows;
}

/// The same of the first row; nothing where there is none. Throws SQLite::Exception.
template <class Read, class... Values>
[[nodiscard]] auto first_row_of(const SQLite::Database& database, const std::string& sql, const Read& read,
                                const Values&... values) {
  SQLite::Statement query(database, sql);
  bind_all(query, values...);
  std::optional<std::invoke_result_t<const Read&, Fields&>> row;
  if (query.executeStep()) {
    Fields fields(query);
    row = read(fields);
  }
  return row;
}

/// The text in the first column.
[[nodiscard]] inline std::string text_from(Fields& fields) { return fields.text(); }

// ---- Files below SQLite

/// Creates an empty file; refuses a path that exists (bad_input).
[[nodiscard]] base::Status create_exclusively(const std::filesystem::path& path);

/// Forces contents and size of a file, or the names in a folder, to the disk (fsync).
[[nodiscard]] base::Status sync_to_disk(const std::filesystem::path& path);

/// Removes a SQLite file with its -wal, -shm and -journal.
void remove_with_companions(const std::filesystem::path& path);

/// SHA-256 of the file's bytes in hexadecimal.
[[nodiscard]] base::Result<std::string> sha256_of_file(const std::filesystem::path& path);

}  // namespace soak::db::sqlite
