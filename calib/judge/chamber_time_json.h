// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calib/judge/chamber_time.h"

namespace soak::calib {

/// The value of `chamber_time` in the document of `soak fit --chamber-time --json` (docs/schema/fit.schema.json):
/// errors in deg/s and m/s².
[[nodiscard]] nlohmann::json chamber_time_json(const ChamberTime& study);

}  // namespace soak::calib
