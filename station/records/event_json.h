// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// An event as it stands in docs/schema/events-list.schema.json.
[[nodiscard]] nlohmann::json event_json(const db::EventRow& event);

/// The document of `soak events verify --json` (docs/schema/events-verify.schema.json). `status`: what was found,
/// of the chain and of what else was asked.
[[nodiscard]] nlohmann::json chain_json(const base::Result<db::EventChain>& chain, const base::Status& status);

}  // namespace soak::station
