// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "calib/vocabulary/segment.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A void record that was made, and what it withdrew.
struct VoidedPart {
  db::RunRow run;
  db::VoidRecord record;
  std::size_t withdrawn = 0;  ///< segments that counted until now and do so no more
  std::size_t counted = 0;    ///< segments that counted until now
};

/// Whether `record`, which is of that unit's run, withdraws the segment of that key.
[[nodiscard]] bool is_withdrawn_by(const calib::SegmentKey& key, const db::VoidRecord& record);

/// Enters `record` of the run `run` into the catalog and its event log; the record's own run and unit are not read.
/// Refuses (bad_input) a run that is void as a whole, and a part that has no segment which still counts: the message
/// lists those that do.
[[nodiscard]] base::Result<VoidedPart> void_part(db::Catalog& catalog, const db::RunRow& run, db::VoidRecord record);

[[nodiscard]] nlohmann::json voided_part_json(const VoidedPart& made);

}  // namespace soak::station
