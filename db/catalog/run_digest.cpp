// SPDX-License-Identifier: Apache-2.0
// The numbers that fits use stand in the catalog, not in the hashed run files: a digest of each run's rows tells
// whether they are still those that were stored.
#include "db/catalog/detail/run_digest.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <utility>
#include <vector>

#include "base/hash.h"
#include "db/catalog/detail/value_digest.h"

namespace soak::db::catalog {
namespace {

void add_value(base::Sha256& hash, const SQLite::Column& value) {
  switch (value.getType()) {
    case SQLITE_NULL:
      return add_null(hash);
    case SQLITE_INTEGER:
      return add_integer(hash, value.getInt64());
    case SQLITE_FLOAT:
      return add_real(hash, value.getDouble());
    default:
      return add_text(hash, value.getString());
  }
}

void add_rows(base::Sha256& hash, const SQLite::Database& database, std::string_view table, std::string_view run_id,
              std::string_view unit) {
  SQLite::Statement query(database, query_of_rows(table));
  sqlite::bind_all(query, run_id, unit);
  while (query.executeStep()) {
    for (int i = 0; i < query.getColumnCount(); ++i) add_value(hash, query.getColumn(i));
    add_number(hash, 'r', 0);
  }
}

}  // namespace

std::string query_of_rows(std::string_view table) {
  // Columns in the order of the schema; the key of segments, blocks and findings goes on with columns 3 to 6.
  const std::string_view columns =
      table == "run"
          ? "run_id, unit, campaign, label, procedure, purpose, epoch, created_utc_s, clock_rate, simulated, "
            "sealed, file_name, file_sha256, content_sha256, latitude_deg, height_m, azimuth_deg, "
            "gravity_mps2, row_count, duration_s, cut_short, continues"
          : "*";
  return fmt::format("SELECT {} FROM {} WHERE run_id = ?1 AND unit = ?2 ORDER BY 3, 4, 5, 6", columns, table);
}

std::string numbers_sha256(const SQLite::Database& database, std::string_view run_id, std::string_view unit) {
  base::Sha256 hash;
  for (const char* table : kRunTables) {
    hash.update(table);
    add_rows(hash, database, table, run_id, unit);
  }
  return base::to_hex(hash.finish());
}

void store_numbers_sha256(SQLite::Database& database, std::string_view run_id, std::string_view unit) {
  sqlite::execute(database, "UPDATE run SET numbers_sha256 = ? WHERE run_id = ? AND unit = ?",
                  numbers_sha256(database, run_id, unit), run_id, unit);
}

void store_all_numbers_sha256(SQLite::Database& database) {
  const auto runs = sqlite::rows_of(database, "SELECT run_id, unit FROM run", [](sqlite::Fields& fields) {
    std::string run_id = fields.text();
    return std::pair(std::move(run_id), fields.text());
  });
  for (const auto& [run_id, unit] : runs) store_numbers_sha256(database, run_id, unit);
}

base::Status check_numbers(const sqlite::Connection& connection, std::string_view run_id, std::string_view unit) {
  const SQLite::Database& database = connection.database();
  const auto stored = sqlite::first_row_of(database, "SELECT numbers_sha256 FROM run WHERE run_id = ? AND unit = ?",
                                           sqlite::text_from, run_id, unit);
  if (stored && *stored == numbers_sha256(database, run_id, unit)) return {};
  return base::corrupt(
      fmt::format("the catalog's numbers of run {} of unit {} are not those that were stored; restore the catalog "
                  "from a copy, or import the recording again under another label and void this run",
                  run_id, unit),
      connection.path().string());
}

}  // namespace soak::db::catalog
