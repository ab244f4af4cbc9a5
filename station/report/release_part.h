// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Why no verdict holds for a unit by this model, whatever its fresh runs say, in words that stand in a sentence: the
/// model is withdrawn, the unit was repaired or changed since, data of the model were withdrawn since, or data of the
/// campaign of its last verification after that (the same as the page of the unit: station/http/jobs_api.cpp). Empty
/// where a verdict may hold. `calibration` is that of `model`, `release` its release_json().
[[nodiscard]] base::Result<std::string> why_no_verdict(const db::Catalog& catalog, const db::UnitRow& unit,
                                                       const db::ModelRow& model, const calib::Calibration& calibration,
                                                       const nlohmann::json& release);

/// The section `release` of a report: state of the model, its last stored verification, who released it, when it
/// expires, and what the rule of release says against it at a time (release_rule.h). A damaged record of a verification
/// is against it, too.
[[nodiscard]] base::Result<nlohmann::json> release_json(const db::Catalog& catalog, const db::ModelRow& model,
                                                        double now_utc_s);

}  // namespace soak::station
