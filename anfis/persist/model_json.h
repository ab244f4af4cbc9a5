// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// The model as JSON, version 2; every number reads back as exactly the same one.
///     {"format": "soak-anfis-model", "version": 2, "order": 0|1, "t_norm": "product"|"minimum",
///      "inputs": [{"name": s, "centre": x, "half_range": x, "min": x, "max": x,
///                  "memberships": [{"shape": "bell", "width": x, "slope": x, "centre": x}, ..]}, ..],
///      "output": {"centre": x, "half_range": x},
///      "rules": [{"premise": [k|null, ..], "gains": [x, ..], "offset": x, "dropped": [j, ..]}, ..]}
/// Members are those of Model; a membership has the parameters that parameter_names() lists for its shape; a premise of
/// null asks nothing of that input; "dropped" may be absent. Refuses (bad_input) a model that validate() refuses: JSON
/// has no NaN.
[[nodiscard]] base::Result<nlohmann::json> model_to_json(const Model& model);

/// The model that model_to_json wrote. Refuses (corrupt) other formats and versions, missing or mistyped members, and
/// models that validate() refuses. Members it does not know are ignored.
[[nodiscard]] base::Result<Model> model_from_json(const nlohmann::json& json);

}  // namespace soak::anfis
