// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::station {

/// All that the file of a type states; null: not stated. docs/schema/type-show.schema.json has its members.
[[nodiscard]] nlohmann::json type_document(const calib::UnitType& type);

/// `folder` and the `types` of it, in the order of their names: the document of GET /api/v1/types. Fails as
/// read_unit_types() does.
[[nodiscard]] base::Result<nlohmann::json> types_document(const std::filesystem::path& folder);

}  // namespace soak::station
