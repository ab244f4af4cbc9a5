// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "db/catalog/catalog.h"

namespace soak::station {

/// A run of the catalog as it stands in JSON results.
[[nodiscard]] nlohmann::json run_document(const db::RunRow& run);

}  // namespace soak::station
