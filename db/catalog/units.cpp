// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Statement.h>

#include "db/catalog/detail/impl.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

UnitRow unit_from(sqlite::Fields& fields) {
  UnitRow unit;
  unit.serial = fields.text();
  unit.type = fields.text();
  unit.epoch = fields.integer32();
  return unit;
}

std::optional<UnitRow> find_unit(const SQLite::Database& database, std::string_view serial) {
  return sqlite::first_row_of(database, "SELECT serial, type, epoch FROM unit WHERE serial = ?", unit_from, serial);
}

void insert_unit(SQLite::Database& database, const UnitRow& unit) {
  sqlite::execute(database, "INSERT OR IGNORE INTO unit_type (name) VALUES (?)", unit.type);
  sqlite::execute(database, "INSERT INTO unit (serial, type, epoch) VALUES (?, ?, ?)", unit.serial, unit.type,
                  unit.epoch);
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
    return impl_->refuse("a unit needs a serial number and a type");
  }
  return impl_->connection.transact("add the unit", [&]() -> base::Result<UnitRow> {
    if (auto known = find_unit(impl_->database(), serial)) return std::move(*known);
    UnitRow added{std::string(serial), std::string(type), 0};
    insert_unit(impl_->database(), added);
    return added;
  });
}

base::Result<UnitRow> Catalog::add_unit(std::string_view serial, std::string_view type, std::string_view user) {
  if (user.empty()) return impl_->refuse("a unit that is added needs a user");
  return impl_->connection.transact("add the unit", [&]() -> base::Result<UnitRow> {
    const bool is_new = !find_unit(impl_->database(), serial);
    auto unit = ensure_unit(serial, type);
    if (unit && is_new) {
      impl_->log({catalog::now_utc_s(), "unit_added", std::string(serial), "as " + unit->type, std::string(user)});
    }
    return unit;
  });
}

base::Result<std::optional<UnitRow>> Catalog::unit(std::string_view serial) const {
  return impl_->connection.run(
      "read the unit", [&]() -> base::Result<std::optional<UnitRow>> { return find_unit(impl_->database(), serial); });
}

base::Result<std::vector<UnitRow>> Catalog::units() const {
  return impl_->rows("read the units", "SELECT serial, type, epoch FROM unit ORDER BY serial", unit_from);
}

base::Result<UnitRow> Catalog::begin_epoch(std::string_view serial, std::string_view reason, std::string_view user) {
  if (reason.empty() || user.empty()) {
    return impl_->refuse("a new epoch needs a reason and a user");
  }
  return impl_->connection.transact("begin an epoch", [&]() -> base::Result<UnitRow> {
    const auto epoch = catalog::epoch_of(impl_->connection, serial);
    if (!epoch) return base::forward_error(epoch);
    sqlite::execute(impl_->database(), "UPDATE unit SET epoch = ? WHERE serial = ?", *epoch + 1, serial);
    impl_->log({catalog::now_utc_s(), "epoch_begun", std::string(serial),
                "epoch " + std::to_string(*epoch + 1) + ", by " + std::string(user) + ": " + std::string(reason),
                std::string(user)});
    return *find_unit(impl_->database(), serial);
  });
}

base::Status Catalog::ensure_campaign(std::string_view name, std::string_view procedure) {
  return impl_->connection.transact("add the campaign", [&]() -> base::Status {
    const auto known = sqlite::first_row_of(impl_->database(), "SELECT procedure FROM campaign WHERE name = ?",
                                            sqlite::text_from, name);
    if (known == procedure) return {};
    if (known) {
      return impl_->refuse("the campaign '" + std::string(name) + "' runs procedure '" + *known + "', not '" +
                           std::string(procedure) + "'; use another name");
    }
    sqlite::execute(impl_->database(), "INSERT INTO campaign (name, procedure) VALUES (?, ?)", name, procedure);
    return {};
  });
}

base::Result<std::vector<std::string>> Catalog::campaigns() const {
  return impl_->rows("read the campaigns", "SELECT name FROM campaign ORDER BY name", sqlite::text_from);
}

}  // namespace soak::db
