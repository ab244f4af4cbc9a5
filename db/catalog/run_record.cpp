// SPDX-License-Identifier: Apache-2.0
#include "db/catalog/run_record.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

#include "db/catalog/detail/impl.h"
#include "db/catalog/detail/run_digest.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

RecordValue value_of(const SQLite::Column& column) {
  switch (column.getType()) {
    case SQLITE_NULL:
      return std::monostate{};
    case SQLITE_INTEGER:
      return std::int64_t{column.getInt64()};
    case SQLITE_FLOAT:
      return column.getDouble();
    default:
      return column.getString();
  }
}

void bind_value(SQLite::Statement& statement, int index, const RecordValue& value) {
  if (std::holds_alternative<std::monostate>(value)) return statement.bind(index);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return statement.bind(index, *integer);
  if (const auto* real = std::get_if<double>(&value)) return statement.bind(index, *real);
  statement.bind(index, std::get<std::string>(value));
}

std::vector<std::string> columns_of(const SQLite::Statement& query) {
  std::vector<std::string> names;
  for (int i = 0; i < query.getColumnCount(); ++i) names.push_back(query.getColumnName(i));
  return names;
}

/// Throws SQLite::Exception.
RecordTable read_table(const SQLite::Database& database, const char* name, std::string_view run_id,
                       std::string_view unit) {
  SQLite::Statement query(database, catalog::query_of_rows(name));
  sqlite::bind_all(query, run_id, unit);
  RecordTable table{name, columns_of(query), {}};
  while (query.executeStep()) {
    std::vector<RecordValue>& row = table.rows.emplace_back();
    for (int i = 0; i < query.getColumnCount(); ++i) row.push_back(value_of(query.getColumn(i)));
  }
  return table;
}

/// A text of a record's one row in the table "run"; empty where it has none of that name.
std::string text_of_run(const RunRecord& record, std::string_view column) {
  if (record.tables.empty() || record.tables.front().rows.size() != 1) return {};
  const RecordTable& run = record.tables.front();
  const auto at = static_cast<std::size_t>(std::ranges::find(run.columns, column) - run.columns.begin());
  if (at >= run.rows.front().size()) return {};
  const auto* text = std::get_if<std::string>(&run.rows.front()[at]);
  return text != nullptr ? *text : std::string();
}

/// Every row belongs to the run, and the columns are those of this catalog: what is entered cannot be anything else.
/// Throws SQLite::Exception.
base::Status check_table(const sqlite::Connection& connection, const RunRecord& record, const RecordTable& table,
                         const char* name) {
  const std::string where = connection.path().string();
  const SQLite::Statement query(connection.database(), catalog::query_of_rows(name));
  if (table.name != name || table.columns != columns_of(query)) {
    return base::bad_input(fmt::format("the record of run {} is of a catalog of another version", record.run_id),
                           where);
  }
  for (const std::vector<RecordValue>& row : table.rows) {
    const bool belongs = row.size() == table.columns.size() && row[0] == RecordValue(record.run_id) &&
                         row[1] == RecordValue(record.unit);
    if (!belongs)
      return base::corrupt(fmt::format("the record of run {} holds rows of another one", record.run_id), where);
  }
  return {};
}

/// What the schema would refuse, with words that help. Throws SQLite::Exception.
base::Status check_new(const sqlite::Connection& connection, const RunRecord& record) {
  const SQLite::Database& database = connection.database();
  const std::string where = connection.path().string();
  if (sqlite::has_row(database, "SELECT 1 FROM run WHERE run_id = ? AND unit = ?", record.run_id, record.unit)) {
    return base::bad_input(fmt::format("the catalog has run {} of unit {} already", record.run_id, record.unit), where);
  }
  const std::string campaign = text_of_run(record, "campaign");
  const std::string label = text_of_run(record, "label");
  const auto same =
      sqlite::first_row_of(database, "SELECT run_id FROM run WHERE campaign = ? AND unit = ? AND label = ?",
                           sqlite::text_from, campaign, record.unit, label);
  if (!same) return {};
  return base::bad_input(fmt::format("campaign '{}' has another run '{}' of unit {} already ({}): two stations gave "
                                     "their campaigns one name",
                                     campaign, label, record.unit, *same),
                         where);
}

/// Throws SQLite::Exception.
void insert_table(SQLite::Database& database, const RecordTable& table) {
  const std::vector<std::string> places(table.columns.size(), "?");
  SQLite::Statement insert(database, fmt::format("INSERT INTO {} ({}) VALUES ({})", table.name,
                                                 fmt::join(table.columns, ", "), fmt::join(places, ", ")));
  for (const std::vector<RecordValue>& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) bind_value(insert, static_cast<int>(i) + 1, row[i]);
    insert.exec();
    insert.reset();
  }
}

}  // namespace

base::Result<RunRecord> Catalog::run_record(std::string_view run_id, std::string_view unit) const {
  return impl_->connection.snapshot("read the run", [&]() -> base::Result<RunRecord> {
    if (auto sound = catalog::check_numbers(impl_->connection, run_id, unit); !sound) return base::forward_error(sound);
    const SQLite::Database& database = impl_->database();
    RunRecord record{std::string(run_id), std::string(unit), catalog::numbers_sha256(database, run_id, unit), {}};
    for (const char* table : catalog::kRunTables) record.tables.push_back(read_table(database, table, run_id, unit));
    return record;
  });
}

base::Status Catalog::add_run_record(const RunRecord& record) {
  const std::string where = impl_->connection.path().string();
  return impl_->connection.transact("add the run", [&]() -> base::Status {
    if (record.tables.size() != catalog::kRunTables.size() || record.tables.front().rows.size() != 1) {
      return base::corrupt(fmt::format("the record of run {} lacks tables", record.run_id), where);
    }
    for (std::size_t i = 0; i < catalog::kRunTables.size(); ++i) {
      auto checked = check_table(impl_->connection, record, record.tables[i], catalog::kRunTables[i]);
      if (!checked) return checked;
    }
    if (auto is_new = check_new(impl_->connection, record); !is_new) return is_new;
    for (const RecordTable& table : record.tables) insert_table(impl_->database(), table);
    catalog::store_numbers_sha256(impl_->database(), record.run_id, record.unit);
    if (catalog::numbers_sha256(impl_->database(), record.run_id, record.unit) != record.numbers_sha256) {
      return base::corrupt(fmt::format("the numbers of run {} of unit {} are not those that its record states",
                                       record.run_id, record.unit),
                           where);
    }
    impl_->log(
        {catalog::now_utc_s(), "run_added", record.run_id,
         fmt::format("unit {}, campaign '{}', label '{}', {} segments, from an archive", record.unit,
                     text_of_run(record, "campaign"), text_of_run(record, "label"), record.tables[1].rows.size())});
    return {};
  });
}

}  // namespace soak::db
