// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "anfis/model.h"
#include "base/result.h"

namespace soak::anfis {

/// The model as JSON, version 1; every number reads back as exactly the same one.
///     {"format": "soak-anfis-model", "version": 1, "membership": "bell"|"gaussian", "order": 0|1,
///      "input": {"centre": x, "half_range": x, "min": x, "max": x}, "output": {"centre": x, "half_range": x},
///      "rules": [{"width": x, "slope": x, "centre": x, "gain": x, "offset": x}, ..]}
/// Members are those of Model and Rule. Refuses (bad_input) a model that validate() refuses: JSON has no NaN.
[[nodiscard]] base::Result<nlohmann::json> model_to_json(const Model& model);

/// The model that model_to_json wrote. Refuses (corrupt) other formats and versions, missing or mistyped members, and
/// models that validate() refuses. Members it does not know are ignored.
[[nodiscard]] base::Result<Model> model_from_json(const nlohmann::json& json);

}  // namespace soak::anfis
