// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/deploy/export_kalibr.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/sensor.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A segment at rest and the run that it is of.
struct StillSegment {
  db::RunRow run;
  calib::Segment segment;
};

/// Seconds from the segment's first sample to its last.
[[nodiscard]] double length_s(const calib::Segment& segment);

/// The unit's longest segment at rest in this epoch: of its sealed, unvoided runs that have samples, whatever their
/// purpose, without segments that the data gate rejected and those in which the fixture turns; the first of equals.
/// Absent where there is none. Fails as the catalog does.
[[nodiscard]] base::Result<std::optional<StillSegment>> longest_still_segment(const db::Catalog& catalog,
                                                                              const std::string& unit,
                                                                              std::int32_t epoch);

/// The document of `soak signal allan --json` of one sensor in a segment at rest, from 5.8 hours at 200 Hz at most
/// (about a second of work); {"reason"} where there is none. Damage of the run file is a failure.
[[nodiscard]] base::Result<nlohmann::json> allan_at_rest(const db::Catalog& catalog, const StillSegment& still,
                                                         calib::Sensor sensor);

/// What a kalibr file is made of.
struct UnitNoise {
  calib::KalibrSource source;
  std::vector<calib::AxisNoise> axes;
};

/// The noise of a unit's sensors in its longest segment at rest of its current epoch. Fails (bad_input) if that is
/// shorter than calib::kKalibrLeastStill_s, and for simulated data unless `simulated`.
[[nodiscard]] base::Result<UnitNoise> unit_noise(const db::Catalog& catalog, const std::string& unit, bool simulated);

}  // namespace soak::station
