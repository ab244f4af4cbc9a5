// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

/// What a catalog holds of a run, to be carried to another catalog.
namespace soak::db {

/// A value as the catalog stores it: none, whole number, double, text.
using RecordValue = std::variant<std::monostate, std::int64_t, double, std::string>;

/// The rows of one table that belong to a run.
struct RecordTable {
  std::string name;
  std::vector<std::string> columns;
  std::vector<std::vector<RecordValue>> rows;  ///< in the order of the table's key; each as long as `columns`
};

/// All rows of one unit's run that its digest covers (docs/file-formats.md): the run itself, segments, blocks,
/// findings.
struct RunRecord {
  std::string run_id;
  std::string unit;
  std::string numbers_sha256;       ///< the digest
  std::vector<RecordTable> tables;  ///< "run", "segment", "block", "finding", in this order
};

}  // namespace soak::db
