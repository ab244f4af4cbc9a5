// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "calib/deploy/export_kalibr.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What a kalibr file is made of.
struct UnitNoise {
  calib::KalibrSource source;
  std::vector<calib::AxisNoise> axes;
};

/// The noise of a unit's sensors in its longest segment at rest of its current epoch (still_segment.h). Refuses a unit
/// whose longest segment is shorter than calib::kKalibrLeastStill_s, saying what to record, and simulated data unless
/// `simulated`.
[[nodiscard]] base::Result<UnitNoise> unit_noise(const db::Catalog& catalog, const std::string& unit, bool simulated);

}  // namespace soak::station
