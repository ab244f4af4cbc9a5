// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/vocabulary/reference.h"

/// What several documents carry as JSON: accepted terms, and the references that were measured with.
namespace soak::calib {

/// Accepted terms as documents carry them, SI: an array, one object per term.
[[nodiscard]] nlohmann::json terms_json(const std::vector<ModelTerm>& terms);

/// The same back. Refuses (corrupt) an unknown sensor and a covariance that is not square; throws json::exception where
/// a member is missing.
[[nodiscard]] base::Result<std::vector<ModelTerm>> terms_of(const nlohmann::json& document);

/// References as people read them: in the units of their kinds (`unit`), times as text, `waiver` null where there is
/// none. A key of `soak fit --json` and of the JSON export (docs/schema/fit.schema.json).
[[nodiscard]] nlohmann::ordered_json references_json(const std::vector<ReferenceUse>& uses);

/// The same in SI and Unix seconds, to the last bit: for the model document.
[[nodiscard]] nlohmann::json stored_references(const std::vector<ReferenceUse>& uses);

/// Back from that. Throws json::exception where a member is missing or of another type; refuses (corrupt) a kind that
/// is none.
[[nodiscard]] base::Result<std::vector<ReferenceUse>> references_of(const nlohmann::json& stored);

}  // namespace soak::calib
