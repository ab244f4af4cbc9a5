// SPDX-License-Identifier: Apache-2.0
#include "station/runs/still_segment.h"

#include "calib/segments/data_gate.h"

namespace soak::station {

double length_s(const calib::Segment& segment) { return segment.t_end_s - segment.t_start_s; }

base::Result<std::optional<StillSegment>> longest_still_segment(const db::Catalog& catalog, const std::string& unit,
                                                                std::int32_t epoch) {
  const auto runs = catalog.runs({.unit = unit, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  std::optional<StillSegment> longest;
  for (const db::RunRow& run : *runs) {
    if (!run.sealed || run.voided || run.epoch != epoch) continue;
    const auto segments = catalog.segments(run.run_id, run.unit, false);
    if (!segments) return base::forward_error(segments);
    for (const calib::Segment& segment : *segments) {
      if (calib::is_rejected(segment) || turns(segment)) continue;
      if (!longest || length_s(segment) > length_s(longest->segment)) longest = StillSegment{run, segment};
    }
  }
  return longest;
}

}  // namespace soak::station
