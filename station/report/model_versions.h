// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What a unit's page says of all versions of its model (docs/schema/http-unit.schema.json): `versions`, the newest
/// first, each with its state, its epoch and `void`, why nothing that was said or made of it holds any more;
/// `released_before`, those before the newest that are released and keep the rule of release now; `simulated_before`,
/// those of them that are of simulated data. A version that cannot be read is void, and in none of those two.
[[nodiscard]] base::Result<nlohmann::json> model_versions(const db::Catalog& catalog, const db::UnitRow& unit);

}  // namespace soak::station
