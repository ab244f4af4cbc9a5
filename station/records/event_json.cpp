// SPDX-License-Identifier: Apache-2.0
#include "station/records/event_json.h"

#include <nlohmann/json.hpp>

#include "base/text.h"

namespace soak::station {

nlohmann::json event_json(const db::EventRow& event) {
  return {{"number", event.number},
          {"utc_s", event.utc_s},
          {"utc", base::utc_text(event.utc_s)},
          {"kind", event.kind},
          {"subject", event.subject},
          {"user", event.user.empty() ? nlohmann::json() : nlohmann::json(event.user)},
          {"text", event.text},
          {"chain_sha256", event.chain_sha256}};
}

nlohmann::json chain_json(const base::Result<db::EventChain>& chain, const base::Status& status) {
  return {{"ok", status.has_value()},
          {"events", chain ? nlohmann::json(chain->events) : nlohmann::json()},
          {"chain_sha256", chain && chain->events > 0 ? nlohmann::json(chain->end_sha256) : nlohmann::json()},
          {"problem", status ? nlohmann::json() : nlohmann::json(status.error().message)},
          {"where", status ? nlohmann::json() : nlohmann::json(status.error().where)}};
}

}  // namespace soak::station
