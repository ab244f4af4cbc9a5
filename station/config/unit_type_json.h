// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "calib/vocabulary/unit_type.h"

namespace soak::station {

/// All that the file of a type states; null: not stated. docs/schema/type-show.schema.json has its members.
[[nodiscard]] nlohmann::json type_document(const calib::UnitType& type);

/// `folder` and the `types` of it, in the order of their names; `troubles`: what is wrong with files that are none. The
/// document of GET /api/v1/types.
[[nodiscard]] nlohmann::json types_document(const std::filesystem::path& folder);

}  // namespace soak::station
