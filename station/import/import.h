// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/run.h"
#include "db/catalog/catalog.h"
#include "station/import/source_recording.h"

namespace soak::station {

/// Whose recording it is, and where it was made.
struct ImportOptions {
  std::string unit;  ///< serial number
  std::string campaign = "default";
  std::string procedure = "import";  ///< of a campaign that is new
  calib::Site site;
  bool simulated = false;
  bool references = false;               ///< the station's references are those that the recording was made with
  std::optional<std::string> unit_type;  ///< of a unit that is new; absent = "generic"
  /// Called now and then with the share that is stored (0..1); returning false stops the import.
  std::function<bool(double)> progress;
};

/// What was done with one run of the file.
struct ImportedRun {
  std::string label;
  std::string run_id;
  bool was_there = false;  ///< the campaign already held exactly these samples: nothing was done
  std::uint64_t rows = 0;
  double duration_s = 0.0;
  std::size_t segments = 0;
  std::string content_sha256;
};

/// A new run of the file whose samples are those of another run.
struct CopiedRun {
  std::string label;
  std::string of_unit;
  std::string of_campaign;
  std::string of_run;
};

struct ImportSummary {
  std::vector<ImportedRun> runs;
  std::vector<CopiedRun> copies;  ///< each also a warning: at most one copy of the unit itself and one of another unit
  std::vector<std::string> warnings;
  std::vector<calib::ReferenceUse> references;  ///< that were noted for the campaign
};

/// Stores every run of a recording as a sealed run file of its own and enters it, with its segments, into the catalog.
/// Nothing is entered before all runs are written, sealed and segmented; on a failure the files are removed again.
///
/// Fails (bad_input) for a run whose label the campaign already has for this unit, if its samples, its site or its
/// being simulated differ; if they are the same nothing is done. Warns where the unit, or another one, has these
/// samples under another label or in another campaign. Fails for a unit of another type, an unknown type,
/// names that are not one plain line of text, and serial numbers too long for a calibration file. With `references`,
/// fails as judge_references() does for each run, at the times in its channel utc_s, else at the time of the import.
[[nodiscard]] base::Result<ImportSummary> store_recording(db::Catalog& catalog, const SourceRecording& recording,
                                                          const std::filesystem::path& source,
                                                          const ImportOptions& options);

}  // namespace soak::station
