// SPDX-License-Identifier: Apache-2.0
#include "db/detail/schema.h"

#include <SQLiteCpp/Column.h>

#include <string>

namespace soak::db::schema {

base::Status migrate(const sqlite::Connection& connection, std::span<const Step> steps, std::uint32_t application_id) {
  return connection.transact("bring the file to the current version", [&]() -> base::Status {
    SQLite::Database& database = connection.database();
    // Inside the transaction: another process may have migrated since the file was opened.
    const std::uint32_t version = database.execAndGet("PRAGMA user_version").getUInt();
    if (version == 0) database.exec("PRAGMA application_id = " + std::to_string(application_id));
    for (const Step& step : steps) {
      if (step.to_version <= version) continue;
      database.exec(step.sql);
      database.exec("PRAGMA user_version = " + std::to_string(step.to_version));
    }
    return {};
  });
}

base::Status check_identity(const sqlite::Identity& identity, std::uint32_t application_id, std::uint32_t newest,
                            std::string_view kind, const std::filesystem::path& path) {
  if (identity.application_id != application_id) {
    return base::bad_input(std::string("this SQLite file is not a Soak ").append(kind), path.string());
  }
  if (identity.user_version > newest) {
    return base::bad_input(
        std::string("the ").append(kind).append(" has version " + std::to_string(identity.user_version) +
                                                ", this soak reads up to version " + std::to_string(newest) +
                                                "; a newer soak is needed"),
        path.string());
  }
  return {};
}

}  // namespace soak::db::schema
