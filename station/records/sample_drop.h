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
};

/// Whether the samples of a run can be dropped, and what that frees. Reads the whole file. Refuses (bad_input) an
/// unknown run, one that has no samples any more, one whose campaign is not over or may still be resumed, and one whose
/// samples a fit, a verification or a report may need: of a session on a bench, and of a unit of which a model of that
/// epoch carries accepted terms. Void runs and pre-flights are needed by nothing. Fails (corrupt) where the file or the
/// catalog's numbers of the run are not those that were sealed.
[[nodiscard]] base::Result<SamplePlan> plan_sample_drop(const db::Catalog& catalog, const std::string& run_id);

/// Looks again at what may have changed since the plan was made (campaign, terms), notes the drop in the catalog and
/// its event log, then removes the file, durably. A loss of power in between leaves the file: the next drop removes it.
/// Fails (internal) where it cannot be removed.
[[nodiscard]] base::Status drop_samples(db::Catalog& catalog, const SamplePlan& plan, std::string_view reason,
                                        std::string_view user);

}  // namespace soak::station
