// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "calib/vocabulary/segment.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A segment at rest and the run that it is of.
struct StillSegment {
  db::RunRow run;
  calib::Segment segment;
};

/// Seconds from the segment's first sample to its last.
[[nodiscard]] double length_s(const calib::Segment& segment);

/// The unit's longest segment at rest in this epoch: of its sealed, unvoided runs, whatever their purpose, without
/// segments that the data gate rejected and those in which the fixture turns; the first of equals. Absent where there
/// is none. Fails as the catalog does.
[[nodiscard]] base::Result<std::optional<StillSegment>> longest_still_segment(const db::Catalog& catalog,
                                                                              const std::string& unit,
                                                                              std::int32_t epoch);

}  // namespace soak::station
