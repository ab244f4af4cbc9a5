// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calib/model/unit_model.h"

namespace soak::calib {

/// The document of `soak fit --json` for one unit (docs/schema/fit.schema.json): biases in deg/s and m/s², scale errors
/// in ppm. Numbers that the data cannot give are null.
[[nodiscard]] nlohmann::json fit_json(const UnitModel& model);

}  // namespace soak::calib
