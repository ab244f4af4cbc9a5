// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/curve_fit.h"
#include "calib/model_term.h"
#include "calib/unit_model.h"
#include "db/catalog.h"
#include "station/check_warnings.h"

namespace soak::station {

/// Fits a unit freed of `terms`, which the new version carries, with all that the station knows of the campaigns of its
/// runs: check standards, references. `input` comes back as it was fitted. Otherwise as fit_unit().
[[nodiscard]] base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                                            const std::vector<calib::ModelTerm>& terms,
                                                            const calib::CurveFitOptions& options, int jobs,
                                                            CheckWarnings& check_warnings);

}  // namespace soak::station
