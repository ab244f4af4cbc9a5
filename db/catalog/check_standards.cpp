// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include "db/catalog/detail/impl.h"
#include "db/detail/fields.h"

namespace soak::db {
namespace {

constexpr const char* kNoReason = "a check standard needs a reason and a user";

/// Unit of a record that has not ended.
std::optional<std::string> unit_of(const SQLite::Database& database, std::string_view check_standard_id) {
  SQLite::Statement query(database,
                          "SELECT unit FROM check_standard LEFT JOIN check_standard_end AS e USING (check_standard_id) "
                          "WHERE check_standard_id = ? AND e.utc_s IS NULL");
  sqlite::bind_all(query, check_standard_id);
  if (!query.executeStep()) return std::nullopt;
  return sqlite::Fields(query).text();
}

bool is_check_standard(const SQLite::Database& database, std::string_view unit) {
  SQLite::Statement query(database,
                          "SELECT 1 FROM check_standard LEFT JOIN check_standard_end AS e USING (check_standard_id) "
                          "WHERE unit = ? AND e.utc_s IS NULL");
  sqlite::bind_all(query, unit);
  return query.executeStep();
}

}  // namespace

base::Result<std::string> Catalog::add_check_standard(const CheckStandardRow& row) {
  return impl_->connection.transact("enter the check standard", [&]() -> base::Result<std::string> {
    const std::string where = impl_->connection.path().string();
    if (row.reason.empty() || row.user.empty()) return base::bad_input(kNoReason, where);
    if (const auto known = catalog::epoch_of(impl_->connection, row.unit); !known) return base::forward_error(known);
    if (is_check_standard(impl_->database(), row.unit)) {
      return base::bad_input("unit '" + row.unit + "' is a check standard already", where);
    }
    std::string id = catalog::new_uuid(row.since_utc_s);
    SQLite::Statement insert(impl_->database(),
                             "INSERT INTO check_standard (check_standard_id, unit, since_utc_s, reason, user) "
                             "VALUES (?, ?, ?, ?, ?)");
    sqlite::bind_all(insert, id, row.unit, row.since_utc_s, row.reason, row.user);
    insert.exec();
    catalog::insert_event(impl_->database(),
                          {row.since_utc_s, "check_standard_added", row.unit, "by " + row.user + ": " + row.reason});
    return id;
  });
}

base::Status Catalog::end_check_standard(std::string_view check_standard_id, const EndRecord& end) {
  return impl_->connection.transact("end the check standard", [&]() -> base::Status {
    const std::string where = impl_->connection.path().string();
    if (end.reason.empty() || end.user.empty()) return base::bad_input(kNoReason, where);
    const auto unit = unit_of(impl_->database(), check_standard_id);
    if (!unit) {
      return base::bad_input(
          "there is no check standard record " + std::string(check_standard_id) + " that has not ended", where);
    }
    SQLite::Statement insert(
        impl_->database(),
        "INSERT INTO check_standard_end (check_standard_id, reason, user, utc_s) VALUES (?, ?, ?, ?)");
    sqlite::bind_all(insert, check_standard_id, end.reason, end.user, end.utc_s);
    insert.exec();
    catalog::insert_event(impl_->database(),
                          {end.utc_s, "check_standard_ended", *unit, "by " + end.user + ": " + end.reason});
    return {};
  });
}

base::Result<std::vector<CheckStandardRow>> Catalog::check_standards() const {
  return impl_->connection.run("read the check standards", [&]() -> base::Result<std::vector<CheckStandardRow>> {
    SQLite::Statement query(impl_->database(),
                            "SELECT check_standard_id, unit, since_utc_s, c.reason, c.user, e.reason, e.user, e.utc_s "
                            "FROM check_standard AS c LEFT JOIN check_standard_end AS e USING (check_standard_id) "
                            "ORDER BY c.rowid");
    std::vector<CheckStandardRow> rows;
    while (query.executeStep()) {
      sqlite::Fields fields(query);
      CheckStandardRow& row = rows.emplace_back();
      row.check_standard_id = fields.text();
      row.unit = fields.text();
      row.since_utc_s = fields.real();
      row.reason = fields.text();
      row.user = fields.text();
      const auto reason = fields.optional_text();
      if (!reason) continue;
      row.ended = EndRecord{*reason, fields.text(), 0.0};
      row.ended->utc_s = fields.real();
    }
    return rows;
  });
}

}  // namespace soak::db
