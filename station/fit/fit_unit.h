// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Sealed, unvoided runs of the unit's current epoch that are for calibration (not for verification, no pre-flight),
/// with the statistics of their segments and the references of their campaigns; of one campaign only, where that is
/// given. Samples that were stored more than once count once (calib/estimate/run_copies.h). Adds to `warnings` what
/// must be told of that and of the unit's type. Refuses an unknown unit or campaign, and a unit without such runs,
/// saying which runs there are and why they do not count; fails (corrupt) for a damaged waiver and a damaged or missing
/// run file.
[[nodiscard]] base::Result<calib::UnitInput> load_unit(const db::Catalog& catalog, const std::string& unit,
                                                       const std::optional<std::string>& campaign,
                                                       std::vector<calib::Warning>& warnings);

/// Refuses (bad_input) a campaign that the catalog does not have, with some that it has.
[[nodiscard]] base::Status check_campaign_known(const db::Catalog& catalog, const std::string& campaign);

/// The unit of a calibration with what its type's file says, in the calibration's epoch; no runs yet.
[[nodiscard]] base::Result<calib::UnitInput> unit_of(const calib::Calibration& calibration);

/// A run of the catalog as input of a fit or a verification. Fails (corrupt) where its file is missing or damaged.
[[nodiscard]] base::Result<calib::RunInput> load_run(const db::Catalog& catalog, const db::RunRow& run);

/// Fits all sensors of a unit on `jobs` threads (0: one per core) and stores the model as the unit's next version.
/// `station_warnings`: what else is to be told of the model. Nothing is stored where a sensor cannot be fitted. The
/// result does not depend on the number of threads.
[[nodiscard]] base::Result<calib::UnitModel> fit_unit(db::Catalog& catalog, const calib::UnitInput& input,
                                                      const calib::CurveFitOptions& options, int jobs,
                                                      const std::vector<calib::Warning>& station_warnings);

}  // namespace soak::station
