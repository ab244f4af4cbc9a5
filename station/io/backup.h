// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A run file that a backup does not hold, and why.
struct UncopiedFile {
  std::string file;  ///< its name in the folder runs
  std::string why;
};

/// What a backup did.
struct BackupSummary {
  db::EventChain events;                 ///< of the copied catalog
  std::vector<std::string> copied;       ///< run files that are new in the backup
  std::vector<std::string> kept;         ///< run files that it had already, read again and found whole
  std::uint64_t copied_bytes = 0;        ///< of run files
  bool on_same_disk = false;             ///< on the file system of the data folder: of no use when the disk dies
  std::vector<UncopiedFile> still_open;  ///< not sealed, or not in the catalog yet: the next backup takes them
  std::vector<UncopiedFile> damaged;  ///< missing or changed at the station, or another file of that name in the backup
};

/// Copies catalog and sealed run files into a folder, which then is a data folder of its own; the station goes on
/// meanwhile. Run files are copied once, compared with their hashes and forced to the disk; the catalog, checked as a
/// whole, takes its place last, so that the backup never names a file that it lacks. Nothing in the folder is ever
/// replaced by something else: a folder whose catalog is not an earlier state of this one is refused (bad_input). Fails
/// (corrupt) where the catalog itself is damaged, (internal) where the disk fails. `progress` is called with the share
/// that is done; false interrupts.
[[nodiscard]] base::Result<BackupSummary> back_up(const db::Catalog& catalog, const std::filesystem::path& folder,
                                                  const std::function<bool(double)>& progress);

}  // namespace soak::station
