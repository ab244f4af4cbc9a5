// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

#include <array>
#include <string>
#include <string_view>

#include "db/detail/sqlite.h"

namespace soak::db::catalog {

/// The tables whose rows make up a run.
inline constexpr std::array<const char*, 4> kRunTables = {"run", "segment", "block", "finding"};

/// Query of the rows that the digest covers: those of run id ?1 and unit ?2 in one of kRunTables, in the order of their
/// keys. The first two columns are run_id and unit.
[[nodiscard]] std::string query_of_rows(std::string_view table);

/// SHA-256 in hexadecimal of what the catalog holds of one unit's part of a run: its row (but for this digest), its
/// segments, blocks and findings, in the order of their keys. Each value counts with its type, so that 1, 1.0, '1' and
/// NULL differ, and a text with its length. Throws SQLite::Exception.
[[nodiscard]] std::string numbers_sha256(const SQLite::Database& database, std::string_view run_id,
                                         std::string_view unit);

/// Enters the digest of a run whose rows are all there. Throws SQLite::Exception.
void store_numbers_sha256(SQLite::Database& database, std::string_view run_id, std::string_view unit);

/// Enters the digests of all runs: a catalog whose version had none takes its rows as they are. Throws
/// SQLite::Exception.
void store_all_numbers_sha256(SQLite::Database& database);

/// Whether the rows of a run are those that were stored; corrupt, naming the run, where they are not. Throws
/// SQLite::Exception.
[[nodiscard]] base::Status check_numbers(const sqlite::Connection& connection, std::string_view run_id,
                                         std::string_view unit);

}  // namespace soak::db::catalog
