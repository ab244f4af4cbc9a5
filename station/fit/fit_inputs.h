// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/model_term.h"
#include "db/catalog/catalog.h"

/// Whether a fit would take anything else than an earlier one did.
namespace soak::station {

/// What a fit is about to take.
struct FitInputs {
  std::string sha256;       ///< of it
  double seen_utc_s = 0.0;  ///< just before it was looked at: what others enter later, a model may not have seen
};

/// `sha256` in hexadecimal is of all that a fit of the unit would take: the program's version, the unit's epoch and the
/// file of its type, its runs with their numbers, voids and dropped samples, what they were measured with, accepted
/// terms and options. Not of what only adds warnings (check standards, and what became of references since), nor of
/// what other units show of hysteresis (fleet_hysteresis.h). Reads rows of the catalog, no samples and no statistics.
/// Refuses an unknown unit; fails as load_unit() does for damaged waivers.
[[nodiscard]] base::Result<FitInputs> fit_inputs_now(const db::Catalog& catalog, const std::string& unit,
                                                     const std::optional<std::string>& campaign,
                                                     const std::vector<calib::ModelTerm>& terms,
                                                     const calib::CurveFitOptions& options);

}  // namespace soak::station
