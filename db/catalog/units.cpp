// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Statement.h>

#include "db/catalog/detail/impl.h"
#include "db/detail/fields.h"

namespace soak::db {
namespace {

UnitRow unit_from(SQLite::Statement& query) {
  sqlite::Fields fields(query);
  UnitRow unit;
  unit.serial = fields.text();
  unit.type = fields.text();
  unit.epoch = fields.integer32();
  return unit;
}

std::optional<UnitRow> find_unit(const SQLite::Database& database, std::string_view serial) {
  SQLite::Statement query(database, "SELECT serial, type, epoch FROM unit WHERE serial = ?");
  sqlite::bind_all(query, serial);
  if (!query.executeStep()) return std::nullopt;
  return unit_from(query);
}

void insert_unit(SQLite::Database& database, const UnitRow& unit) {
  SQLite::Statement add_type(database, "INSERT OR IGNORE INTO unit_type (name) VALUES (?)");
  sqlite::bind_all(add_type, unit.type);
  add_type.exec();
  SQLite::Statement add_unit(database, "INSERT INTO unit (serial, type, epoch) VALUES (?, ?, ?)");
  sqlite::bind_all(add_unit, unit.serial, unit.type, unit.epoch);
  add_unit.exec();
}

}  // namespace

namespace catalog {

base::Result<std::int32_t> epoch_of(const sqlite::Connection& connection, std::string_view serial) {
  const auto unit = find_unit(connection.database(), serial);
  if (unit) return unit->epoch;
  return base::bad_input("the catalog has no unit '" + std::string(serial) + "'; add it first",
                         connection.path().string());
}

}  // namespace catalog

base::Result<UnitRow> Catalog::ensure_unit(std::string_view serial, std::string_view type) {
  if (serial.empty() || type.empty()) {
    return base::bad_input("a unit needs a serial number and a type", impl_->connection.path().string());
  }
  return impl_->connection.transact("add the unit", [&]() -> base::Result<UnitRow> {
    if (auto known = find_unit(impl_->database(), serial)) return std::move(*known);
    UnitRow added{std::string(serial), std::string(type), 0};
    insert_unit(impl_->database(), added);
    return added;
  });
}

base::Result<std::optional<UnitRow>> Catalog::unit(std::string_view serial) const {
  return impl_->connection.run(
      "read the unit", [&]() -> base::Result<std::optional<UnitRow>> { return find_unit(impl_->database(), serial); });
}

base::Result<std::vector<UnitRow>> Catalog::units() const {
  return impl_->connection.run("read the units", [&]() -> base::Result<std::vector<UnitRow>> {
    SQLite::Statement query(impl_->database(), "SELECT serial, type, epoch FROM unit ORDER BY serial");
    std::vector<UnitRow> units;
    while (query.executeStep()) units.push_back(unit_from(query));
    return units;
  });
}

base::Result<UnitRow> Catalog::begin_epoch(std::string_view serial, std::string_view reason, std::string_view user) {
  if (reason.empty() || user.empty()) {
    return base::bad_input("a new epoch needs a reason and a user", impl_->connection.path().string());
  }
  return impl_->connection.transact("begin an epoch", [&]() -> base::Result<UnitRow> {
    const auto epoch = catalog::epoch_of(impl_->connection, serial);
    if (!epoch) return base::forward_error(epoch);
    SQLite::Statement update(impl_->database(), "UPDATE unit SET epoch = ? WHERE serial = ?");
    sqlite::bind_all(update, *epoch + 1, serial);
    update.exec();
    catalog::insert_event(impl_->database(), {catalog::now_utc_s(), "epoch_begun", std::string(serial),
                                              "epoch " + std::to_string(*epoch + 1) + ", by " + std::string(user) +
                                                  ": " + std::string(reason)});
    return *find_unit(impl_->database(), serial);
  });
}

base::Status Catalog::ensure_campaign(std::string_view name, std::string_view procedure) {
  return impl_->connection.transact("add the campaign", [&]() -> base::Status {
    SQLite::Statement query(impl_->database(), "SELECT procedure FROM campaign WHERE name = ?");
    sqlite::bind_all(query, name);
    if (query.executeStep()) {
      const std::string known = sqlite::Fields(query).text();
      if (known == procedure) return {};
      return base::bad_input("the campaign '" + std::string(name) + "' runs procedure '" + known + "', not '" +
                                 std::string(procedure) + "'; use another name",
                             impl_->connection.path().string());
    }
    SQLite::Statement insert(impl_->database(), "INSERT INTO campaign (name, procedure) VALUES (?, ?)");
    sqlite::bind_all(insert, name, procedure);
    insert.exec();
    return {};
  });
}

base::Result<std::vector<std::string>> Catalog::campaigns() const {
  return impl_->connection.run("read the campaigns", [&]() -> base::Result<std::vector<std::string>> {
    SQLite::Statement query(impl_->database(), "SELECT name FROM campaign ORDER BY name");
    std::vector<std::string> names;
    while (query.executeStep()) names.push_back(sqlite::Fields(query).text());
    return names;
  });
}

}  // namespace soak::db
