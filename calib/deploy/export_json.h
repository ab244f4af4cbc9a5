// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::calib {

/// The whole calibration as one JSON document for people and scripts (docs/schema/calibration.schema.json), ending in a
/// line feed: provenance, and for each sensor its parameters and its curve at temp_min_c, every 1 °C, and temp_max_c.
/// Biases are in printed units (deg/s, m/s²), parameters too; scale factor errors in ppm. Refuses numbers that are not
/// finite, which JSON cannot carry, and models that anfis::validate_curve() refuses, which the document has no members
/// for.
[[nodiscard]] base::Result<std::string> export_json(const Calibration& calibration);

}  // namespace soak::calib
