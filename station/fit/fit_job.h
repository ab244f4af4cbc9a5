// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/model_term.h"
#include "calib/model/unit_model.h"
#include "db/catalog/catalog.h"
#include "station/fit/check_warnings.h"

namespace soak::station {

/// Fits a unit freed of `terms`, which the new version carries, with all that the station knows of the campaigns of its
/// runs: check standards, references. `input` comes back as it was fitted; `warnings` are told with the others.
/// Otherwise as fit_unit().
[[nodiscard]] base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                                            const std::vector<calib::ModelTerm>& terms,
                                                            const calib::CurveFitOptions& options, int jobs,
                                                            CheckWarnings& check_warnings,
                                                            std::vector<calib::Warning> warnings = {});

/// Fits a unit as `parent` was fitted, to the same runs with the same options, but freed of `terms`. What was voided
/// since is left out, with the warning `runs_left_since`; refuses (bad_input) where nothing is left.
[[nodiscard]] base::Result<calib::UnitModel> fit_again(db::Catalog& catalog, const db::ModelRow& parent,
                                                       const std::vector<calib::ModelTerm>& terms);

}  // namespace soak::station
