// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

/// Samples that a laboratory gives up to make room on its disk (docs/records.md): the run file goes, the statistics
/// that fits use, findings, records and models stay.
namespace soak::station {

/// What dropping the samples of a run would free.
struct SamplePlan {
  db::RunRow run;                  ///< of the first of its units
  std::vector<std::string> units;  ///< all that the file holds
  std::string source;              ///< RunInfo::source of the file
  std::uint64_t bytes = 0;
  bool is_noted = false;  ///< they were dropped before, but the file is still there: only that is left to do
};

/// Whether the samples of a run can be dropped, and what that frees. Reads the whole file. Refuses (bad_input) an
/// unknown run, one whose campaign is not over, one whose samples are dropped and gone, and one whose samples a later
/// fit or verification needs: of a session on a bench, and of a unit whose model carries accepted terms. Fails
/// (corrupt) where the file or the catalog's numbers of the run are not those that were sealed.
[[nodiscard]] base::Result<SamplePlan> plan_sample_drop(const db::Catalog& catalog, const std::string& run_id);

/// Notes the drop in the catalog and its event log, then removes the file, durably; a loss of power in between leaves a
/// file that the next plan_sample_drop() finds. Fails (internal) where it cannot be removed.
[[nodiscard]] base::Status drop_samples(db::Catalog& catalog, const SamplePlan& plan, std::string_view reason,
                                        std::string_view user);

}  // namespace soak::station
