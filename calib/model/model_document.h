// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/model/unit_model.h"

namespace soak::calib {

/// The document of `soak fit --json` for one unit (docs/schema/fit.schema.json): biases in deg/s and m/s², scale errors
/// in ppm. Numbers that the data cannot give are null.
[[nodiscard]] nlohmann::json fit_json(const UnitModel& model);

/// The JSON text that the catalog stores for a model version: what `soak fit --json` printed ("fit"), and the
/// calibration in SI, to the last bit ("calibration"). Refuses a model with a curve that cannot be evaluated.
[[nodiscard]] base::Result<std::string> model_document(const UnitModel& model);

/// The calibration of a stored model. Refuses (corrupt) a document that is not one, naming what is missing; (bad_input)
/// one of a newer format.
[[nodiscard]] base::Result<Calibration> calibration_of(std::string_view document);

/// The options that a stored model was fitted with; the defaults in a document of a program that kept none. Refuses as
/// calibration_of().
[[nodiscard]] base::Result<CurveFitOptions> fit_options_of(std::string_view document);

/// The accepted terms of a stored model; none in a document of a program that knew none. Refuses as calibration_of().
[[nodiscard]] base::Result<std::vector<ModelTerm>> model_terms_of(std::string_view document);

}  // namespace soak::calib
