// SPDX-License-Identifier: Apache-2.0
#include "db/catalog/detail/seals.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "base/text.h"
#include "db/catalog/catalog.h"
#include "db/catalog/detail/value_digest.h"
#include "db/detail/schema.h"

namespace soak::db::catalog {
namespace {

struct SealedTable {
  std::string_view name;
  int since_version;  ///< of the schema
};

/// All tables but those with digests of their own: segment, block and finding (of each run), event (a chain).
constexpr std::array<SealedTable, 21> kSealedTables = {{{"unit_type", 2},
                                                        {"unit", 2},
                                                        {"campaign", 2},
                                                        {"journal", 2},
                                                        {"step", 2},
                                                        {"run", 2},
                                                        {"void", 2},
                                                        {"model", 2},
                                                        {"gap_report", 2},
                                                        {"calibration", 2},
                                                        {"reference", 2},
                                                        {"reference_retirement", 2},
                                                        {"waiver", 2},
                                                        {"reference_withdrawal", 2},
                                                        {"campaign_reference", 2},
                                                        {"check_standard", 2},
                                                        {"check_standard_end", 2},
                                                        {"sample_drop", 2},
                                                        {"model_origin", 3},
                                                        {"model_state", 3},
                                                        {"verification", 3}}};

constexpr std::size_t kSealBytes = 32;
constexpr const char* kNoRows = "0000000000000000000000000000000000000000000000000000000000000000";

void add_value(base::Sha256& hash, sqlite3_value* value) {
  switch (sqlite3_value_type(value)) {
    case SQLITE_INTEGER:
      return add_integer(hash, sqlite3_value_int64(value));
    case SQLITE_FLOAT:
      return add_real(hash, sqlite3_value_double(value));
    case SQLITE_NULL:
      return add_null(hash);
    default: {
      const auto* text = static_cast<const char*>(sqlite3_value_blob(value));
      add_text(hash, {text, static_cast<std::size_t>(sqlite3_value_bytes(value))});
    }
  }
}

/// soak_seal(seal, table, values...)
void seal_function(sqlite3_context* context, int count, sqlite3_value** arguments) {
  const auto* seal = reinterpret_cast<const char*>(sqlite3_value_text(arguments[0]));
  const auto before = base::bytes_of_hex<kSealBytes>(seal == nullptr ? "" : seal);
  base::Sha256 hash;
  for (int i = 1; i < count; ++i) add_value(hash, arguments[i]);
  auto row = hash.finish();
  if (!before) return sqlite3_result_error(context, "not a seal", -1);
  for (std::size_t i = 0; i < row.size(); ++i) row[i] ^= (*before)[i];
  const std::string after = base::to_hex(row);
  sqlite3_result_text(context, after.c_str(), static_cast<int>(after.size()), SQLITE_TRANSIENT);
}

/// The columns of a table, each behind `prefix`, with commas before them.
std::string columns_of(const SQLite::Database& database, std::string_view table, std::string_view prefix) {
  std::string columns;
  const auto names =
      sqlite::rows_of(database, "SELECT name FROM pragma_table_info(?) ORDER BY cid", sqlite::text_from, table);
  for (const std::string& name : names) columns += fmt::format(", {}{}", prefix, name);
  return columns;
}

/// A row comes, changes or goes: its old values leave the seal, its new ones enter it.
std::string triggers_of(const SQLite::Database& database, std::string_view table) {
  const std::string old_row = fmt::format("'{}'{}", table, columns_of(database, table, "OLD."));
  const std::string new_row = fmt::format("'{}'{}", table, columns_of(database, table, "NEW."));
  return fmt::format(
      R"sql(
CREATE TRIGGER {0}_seals_new AFTER INSERT ON {0} BEGIN
  UPDATE seal SET row_count = row_count + 1, sha256 = soak_seal(sha256, {2}) WHERE name = '{0}';
END;
CREATE TRIGGER {0}_seals_change AFTER UPDATE ON {0} BEGIN
  UPDATE seal SET sha256 = soak_seal(soak_seal(sha256, {1}), {2}) WHERE name = '{0}';
END;
CREATE TRIGGER {0}_seals_loss AFTER DELETE ON {0} BEGIN
  UPDATE seal SET row_count = row_count - 1, sha256 = soak_seal(sha256, {1}) WHERE name = '{0}';
END;
)sql",
      table, old_row, new_row);
}

using Seal = std::pair<std::int64_t, std::string>;  ///< number of rows and their digest

/// What the rows of a table give. The digests are folded row by row: exclusive-or knows no order.
Seal seal_of_rows(const SQLite::Database& database, std::string_view table) {
  Seal seal{0, kNoRows};
  SQLite::Statement rows(database, fmt::format("SELECT soak_seal('{}', '{}'{}) FROM {}", kNoRows, table,
                                               columns_of(database, table, ""), table));
  std::array<std::uint8_t, kSealBytes> sum{};
  while (rows.executeStep()) {
    const auto row = base::bytes_of_hex<kSealBytes>(rows.getColumn(0).getString());
    for (std::size_t i = 0; row && i < sum.size(); ++i) sum[i] ^= (*row)[i];
    ++seal.first;
  }
  seal.second = base::to_hex(sum);
  return seal;
}

base::Status check_seal(const sqlite::Connection& connection, std::string_view table) {
  const auto stored = sqlite::first_row_of(
      connection.database(), "SELECT row_count, sha256 FROM seal WHERE name = ?",
      [](sqlite::Fields& fields) {
        const std::int64_t count = fields.integer();
        return Seal{count, fields.text()};
      },
      table);
  const Seal found = seal_of_rows(connection.database(), table);
  if (stored && *stored == found) return {};
  return base::corrupt(fmt::format("the rows of table '{}' are not those that were stored ({} rows, {} by its seal); "
                                   "restore the catalog from a backup",
                                   table, found.first, stored ? std::to_string(stored->first) : "none"),
                       connection.path().string());
}

/// Name and text of everything in the schema, in the order of the names.
std::vector<std::pair<std::string, std::string>> schema_of(const SQLite::Database& database) {
  return sqlite::rows_of(
      database, "SELECT type || ' ' || name || ' on ' || tbl_name, coalesce(sql, '') FROM sqlite_master ORDER BY 1",
      [](sqlite::Fields& fields) {
        std::string name = fields.text();
        return std::pair(std::move(name), fields.text());
      });
}

}  // namespace

void add_seal_function(SQLite::Database& database) {
  // Innocuous: triggers of a schema that is not trusted may call it, as it does nothing but reckon.
  const int flags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
  const int code = sqlite3_create_function_v2(database.getHandle(), "soak_seal", -1, flags, nullptr, seal_function,
                                              nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) throw SQLite::Exception(database.getHandle(), code);
}

void make_seals(SQLite::Database& database, int schema_version) {
  for (const auto& [table, since_version] : kSealedTables) {
    if (since_version != schema_version) continue;
    database.exec(triggers_of(database, table));
    const auto [rows, sha256] = seal_of_rows(database, table);
    sqlite::execute(database, "INSERT INTO seal (name, row_count, sha256) VALUES (?, ?, ?)", table, rows, sha256);
  }
}

base::Status check_seals(const sqlite::Connection& connection, std::span<const std::string_view> tables) {
  for (const std::string_view table : tables) {
    if (auto sound = check_seal(connection, table); !sound) return sound;
  }
  return {};
}

base::Status check_all_seals(const sqlite::Connection& connection) {
  for (const SealedTable& table : kSealedTables) {
    if (auto sound = check_seal(connection, table.name); !sound) return sound;
  }
  return {};
}

base::Status check_schema(const sqlite::Connection& connection) {
  auto fresh = sqlite::Connection::open(":memory:", sqlite::Access::read_write);
  if (!fresh) return base::forward_error(fresh);
  add_seal_function(fresh->database());
  auto made = schema::migrate(*fresh, schema::station_steps(), schema::kStationApplicationId);
  if (!made) return made;
  const auto expected = schema_of(fresh->database());
  const auto found = schema_of(connection.database());
  for (std::size_t i = 0; i < expected.size() || i < found.size(); ++i) {
    if (i < expected.size() && i < found.size() && expected[i] == found[i]) continue;
    return base::corrupt(fmt::format("the schema of the catalog is not that of this program, first at '{}'; restore "
                                     "the catalog from a backup",
                                     i < expected.size() ? expected[i].first : found[i].first),
                         connection.path().string());
  }
  return {};
}

}  // namespace soak::db::catalog
