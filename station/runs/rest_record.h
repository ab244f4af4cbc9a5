// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "calib/signal/documents/signal_json.h"
#include "calib/vocabulary/sensor.h"
#include "db/catalog/catalog.h"
#include "station/runs/still_segment.h"

namespace soak::station {

/// Why there is no noise of a unit without a segment at rest (longest_still_segment()).
inline constexpr const char* kNothingAtRest =
    "no run of the unit that has its samples has a segment at rest that the data gate accepts";

/// A segment at rest as documents say it (`noise.segment` of docs/schema/report.schema.json).
[[nodiscard]] nlohmann::json still_segment_json(const StillSegment& still);

/// The readings of one sensor in a segment at rest, 5.8 hours at 200 Hz at most. Refuses what read_run_signal() does.
[[nodiscard]] base::Result<calib::SignalRecord> record_at_rest(const db::Catalog& catalog, const StillSegment& still,
                                                               calib::Sensor sensor);

}  // namespace soak::station
