// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/archive/archive.h"
#include "station/archive/archive_record.h"
#include "station/archive/archive_store.h"

/// Files and records out of an archive, each checked by its hash. For the files of this folder.
namespace soak::station {

/// The folders of an archive.
inline const std::string kArchiveFiles = "files";
inline const std::string kArchiveRecords = "records";

[[nodiscard]] std::string archived_file_name(const std::string& sha256);
[[nodiscard]] std::string archived_record_name(const std::string& sha256);

/// A folder for files on their way. It is gone again at the end.
class ArchiveScratch {
 public:
  ArchiveScratch() = default;
  ArchiveScratch(const ArchiveScratch&) = delete;
  ArchiveScratch& operator=(const ArchiveScratch&) = delete;
  ~ArchiveScratch();

  /// Fails (internal) where there is no place for temporary files ($TMPDIR).
  [[nodiscard]] base::Status make();
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

/// Fails (internal) where `progress` interrupts.
[[nodiscard]] base::Status report_progress(const ArchiveProgress& progress, std::size_t done, std::size_t of);

/// "campaign/label".
[[nodiscard]] std::string name_of_run(const ArchiveRecord& record);

/// Whether a failure is of one run alone, so that the others go on.
[[nodiscard]] bool is_about_the_run(const base::Error& error);

/// Gets a file whose name states its hash. Fails (corrupt) where that is not its hash, (internal) where it cannot be
/// read.
[[nodiscard]] base::Status get_checked(const ArchiveStore& store, const std::string& folder, const std::string& name,
                                       const std::filesystem::path& to);

/// Compares a file of the archive with the hash that its name states: where it lies, or, of a remote, as `scratch`.
/// Fails as get_checked() does.
[[nodiscard]] base::Status check_archived(const ArchiveStore& store, const std::string& folder, const std::string& name,
                                          const std::filesystem::path& scratch);

/// `visit` with each record that is whole; the others are troubles. Fails (bad_input) where no archive is.
[[nodiscard]] base::Status for_each_record(const ArchiveStore& store, const ArchiveProgress& progress,
                                           std::vector<ArchiveTrouble>& troubles,
                                           const std::function<base::Status(ArchiveRecord)>& visit);

}  // namespace soak::station
