// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>

/// The event log is a chain: each event carries the SHA-256 of itself and of the one before it. The end of the chain
/// stands in the table `seal`, so that events cut off at the end are missed, too.
namespace soak::db::catalog {

/// Chains the events that are there, in the order of their arrival: a step of the schema. Throws SQLite::Exception.
void chain_all_events(SQLite::Database& database);

}  // namespace soak::db::catalog
