// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <span>
#include <string_view>

#include "db/detail/sqlite.h"

/// Seals of the catalog's tables: for each table the number of its rows and a digest of them all, kept up by triggers.
/// A row that changes, comes or goes by any other way than this program no longer fits its table's seal.
namespace soak::db::catalog {

/// Gives a connection the function by which the triggers reckon, soak_seal(seal, table, values...): `seal` exclusive-or
/// the SHA-256 of the table's name and the values of a row. Without it nobody can write to a sealed table. Throws
/// SQLite::Exception.
void add_seal_function(SQLite::Database& database);

/// Makes the triggers of the tables that a version of the schema began to seal, and seals the rows that are there: a
/// step of the schema. Throws SQLite::Exception.
void make_seals(SQLite::Database& database, int schema_version);

/// Whether the rows of the tables are those that their seals stand for; corrupt, naming the first table that is not.
/// Throws SQLite::Exception.
[[nodiscard]] base::Status check_seals(const sqlite::Connection& connection, std::span<const std::string_view> tables);

/// The same of all sealed tables.
[[nodiscard]] base::Status check_all_seals(const sqlite::Connection& connection);

/// Whether tables, indexes, triggers and views are those of this program's schema; corrupt, naming the first that is
/// not. Throws SQLite::Exception.
[[nodiscard]] base::Status check_schema(const sqlite::Connection& connection);

}  // namespace soak::db::catalog
