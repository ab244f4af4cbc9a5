// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "db/detail/sqlite.h"

namespace soak::db {

struct Catalog::Impl {
  Impl(std::filesystem::path folder, sqlite::Connection opened)
      : data_folder(std::move(folder)), connection(std::move(opened)) {}

  [[nodiscard]] SQLite::Database& database() const { return connection.database(); }
  /// bad_input about the catalog.
  [[nodiscard]] tl::unexpected<base::Error> refuse(std::string message) const {
    return base::bad_input(std::move(message), connection.path().string());
  }

  /// Appends to the event log, inside the caller's transaction; by the user that act_as() named where the event names
  /// none. Throws SQLite::Exception.
  void log(EventRow event);

  /// What `read` makes of each row of a query; an error says "cannot `doing`".
  template <class Read, class... Values>
  [[nodiscard]] auto rows(std::string_view doing, const std::string& sql, const Read& read,
                          const Values&... values) const {
    using Rows = std::vector<std::invoke_result_t<const Read&, sqlite::Fields&>>;
    return connection.run(doing,
                          [&]() -> base::Result<Rows> { return sqlite::rows_of(database(), sql, read, values...); });
  }

  /// Refuses (corrupt) a run whose numbers are not those that were stored, and any run where the tables that fits rest
  /// on are not; (bad_input) one that is not there. What was checked once is not checked again. Throws
  /// SQLite::Exception.
  [[nodiscard]] base::Status check_run_of_fits(std::string_view run_id, std::string_view unit);
  /// The last drop of a run's samples; nothing where there was none.
  [[nodiscard]] base::Result<std::optional<SampleDrop>> drop_of(std::string_view run_id) const;

  std::filesystem::path data_folder;
  sqlite::Connection connection;
  std::string user;                                     ///< who works with the catalog; empty = not known
  bool read_only = false;                               ///< an archive
  bool seals_are_sound = false;                         ///< those that fits rest on were checked
  std::set<std::pair<std::string, std::string>> sound;  ///< run and unit whose numbers were checked
  std::map<std::string, std::string> file_sha256;       ///< of the run files that check_run_file() has read, by name
};

namespace catalog {

/// Unix time now.
[[nodiscard]] double now_utc_s();

/// A fresh UUIDv7 for something that happened at `utc_s`.
[[nodiscard]] std::string new_uuid(double utc_s);

/// Appends to the event log and its chain, inside the caller's transaction. Throws SQLite::Exception.
void insert_event(SQLite::Database& database, const EventRow& event);

/// Epoch of a unit; bad_input where the unit is unknown. Throws SQLite::Exception.
[[nodiscard]] base::Result<std::int32_t> epoch_of(const sqlite::Connection& connection, std::string_view serial);

/// Refuses a run of a unit that is not in the catalog. Throws SQLite::Exception.
[[nodiscard]] base::Status require_run(const sqlite::Connection& connection, std::string_view run_id,
                                       std::string_view unit);

/// Refuses a model that is not in the catalog. Throws SQLite::Exception.
[[nodiscard]] base::Status require_model(const sqlite::Connection& connection, std::string_view unit,
                                         std::int32_t version);

/// Stores the statistics of one segment with its blocks and findings. Throws SQLite::Exception.
void insert_segment(SQLite::Database& database, const calib::Segment& segment);

}  // namespace catalog
}  // namespace soak::db
