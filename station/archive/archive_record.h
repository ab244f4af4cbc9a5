// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "db/catalog/run_record.h"

/// What an archive keeps beside a run file: the catalog's entries of it (docs/file-formats.md).
namespace soak::station {

/// A run file with all that another catalog must know to have the same run.
struct ArchiveRecord {
  std::string run_id;
  std::string file_name;    ///< in the folder `runs`
  std::string file_sha256;  ///< the file's name in the archive
  std::uint64_t bytes = 0;
  std::string campaign;
  std::string procedure;  ///< of the campaign
  std::string label;
  double created_utc_s = 0.0;
  std::size_t references = 0;       ///< certificates that the campaign was measured with; the record does not hold them
  std::vector<db::UnitRow> units;   ///< each unit of the file, as it was when the record was made
  std::vector<db::RunRecord> runs;  ///< one for each unit, in the same order
  std::vector<db::VoidRecord> voids;
};

/// The record of the run of these rows (all units of one run file), as JSON text. The same catalog entries always give
/// the same text. Fails as Catalog::run_record() does.
[[nodiscard]] base::Result<std::string> archive_record(const db::Catalog& catalog, const std::vector<db::RunRow>& rows);

/// Reads a record. Fails (corrupt) where something is missing or is none; (bad_input) for a newer format.
[[nodiscard]] base::Result<ArchiveRecord> read_archive_record(std::string_view text, const std::string& where);

}  // namespace soak::station
