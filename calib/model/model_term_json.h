// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"

namespace soak::calib {

/// Accepted terms as documents carry them, SI: an array, one object per term.
[[nodiscard]] nlohmann::json terms_json(const std::vector<ModelTerm>& terms);

/// The same back. Refuses (corrupt) an unknown sensor and a covariance that is not square; throws json::exception where
/// a member is missing.
[[nodiscard]] base::Result<std::vector<ModelTerm>> terms_of(const nlohmann::json& document);

}  // namespace soak::calib
