// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/archive/archive_record.h"
#include "station/archive/archive_store.h"

/// One archive for several stations: sealed run files and the catalogs' entries of them, under the SHA-256 of what they
/// hold (docs/scale-out.md). Nothing in it is ever changed, so any number of stations may push and pull at once.
namespace soak::station {

/// Gets the share that is done; false interrupts between two files.
using ArchiveProgress = std::function<bool(double)>;

/// Something in the archive or at the station that was left out, and why.
struct ArchiveTrouble {
  std::string name;  ///< of a file, or of a run: "campaign/label"
  base::Error error;
};

/// What a push did.
struct PushSummary {
  std::vector<std::string> files;        ///< run files that are new in the archive
  std::uint64_t bytes = 0;               ///< of them
  std::size_t files_there = 0;           ///< run files that it had
  std::size_t records = 0;               ///< new in the archive
  std::vector<std::string> open;         ///< run files that are not sealed yet: the next push takes them
  std::vector<std::string> dropped;      ///< run files whose samples were dropped before they were in the archive
  std::vector<ArchiveTrouble> troubles;  ///< damaged at the station
};

/// Brings all sealed run files of a catalog into the archive, each checked by its hash, and a record of each; what is
/// there is not brought again. A damaged run does not hold the others. Fails (internal) where the archive does.
[[nodiscard]] base::Result<PushSummary> push_to_archive(const db::Catalog& catalog, ArchiveStore& store,
                                                        const ArchiveProgress& progress);

/// What a pull did.
struct PullSummary {
  std::vector<std::string> runs;         ///< that are new here: "campaign/label"
  std::uint64_t bytes = 0;               ///< of their files
  std::size_t runs_there = 0;            ///< that this station had
  std::size_t voids = 0;                 ///< void records that are new here
  std::vector<std::string> warnings;     ///< what the archive does not carry
  std::vector<ArchiveTrouble> troubles;  ///< damaged in the archive (corrupt), or at odds with this catalog (bad_input)
};

/// Brings all runs of the archive that the catalog does not have into it, each with its file, segments and void
/// records, all or nothing, and what was voided since of those that it has. Each file is checked by its hash. At odds
/// with this catalog are: another run of that campaign, unit and label; a campaign of another procedure; a unit of
/// another type; another file in the place of the run's. Such a run does not hold the others. A unit's epoch becomes
/// the higher one. `user` is who pulls. Fails (bad_input) where no archive is, (internal) where archive or disk do.
[[nodiscard]] base::Result<PullSummary> pull_from_archive(db::Catalog& catalog, const ArchiveStore& store,
                                                          const std::string& user, const ArchiveProgress& progress);

/// What is in an archive.
struct ArchiveListing {
  std::vector<ArchiveRecord> runs;  ///< each once, by the record with the most voids; by campaign and label
  std::vector<ArchiveTrouble> troubles;
};
/// Fails as pull_from_archive() does.
[[nodiscard]] base::Result<ArchiveListing> list_archive(const ArchiveStore& store);

/// Whether an archive holds what it says.
struct ArchiveCheck {
  std::size_t records = 0;
  std::size_t files = 0;
  std::vector<std::string> without_record;  ///< run files that no record names: of a push that was cut off
  std::vector<ArchiveTrouble> troubles;     ///< missing or damaged
};
/// Reads every byte of the archive. Fails as pull_from_archive() does.
[[nodiscard]] base::Result<ArchiveCheck> verify_archive(const ArchiveStore& store, const ArchiveProgress& progress);

}  // namespace soak::station
