// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calib/gap/report/gap_report.h"

namespace soak::calib::gap {

/// The document of `soak gap find --json` (docs/schema/gap-find.schema.json): deg/s and m/s².
[[nodiscard]] nlohmann::json gap_json(const GapReport& report);

}  // namespace soak::calib::gap
