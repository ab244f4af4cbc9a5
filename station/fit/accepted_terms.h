// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/estimate/model_term.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Accepted terms that the unit's newest model carries; none where it has no model, or only of another epoch.
[[nodiscard]] base::Result<std::vector<calib::ModelTerm>> accepted_terms(const db::Catalog& catalog,
                                                                         const std::string& unit, std::int32_t epoch);

/// Terms of a calibration file that a device corrects while its temperature moves (soak_apply_moving).
[[nodiscard]] std::vector<calib::ModelTerm> moving_terms(const calib::Calibration& calibration);

/// Takes terms off the segments of `input`, and notes them there; the run files are read for it. `warnings` gets what
/// could not be taken off (`term_not_evaluated`). Without terms nothing is done.
[[nodiscard]] base::Status take_terms_off(const db::Catalog& catalog, const std::vector<calib::ModelTerm>& terms,
                                          calib::UnitInput& input, std::vector<calib::Warning>& warnings);

}  // namespace soak::station
