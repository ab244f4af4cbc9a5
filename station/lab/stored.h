// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/config/station_config.h"

namespace soak::station {

/// What the station has, for a page that shows it while nothing runs (docs/http-api.md): the slots of the
/// configuration, the catalog's units with their newest run, its campaigns, newest first. Reads no samples.
[[nodiscard]] base::Result<nlohmann::json> stored_document(const StationConfig& config, const db::Catalog& catalog);

}  // namespace soak::station
