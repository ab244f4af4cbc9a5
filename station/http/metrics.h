// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace soak::station {

/// The status document (docs/http-api.md) and the space that is left for recordings, as Prometheus reads it: text
/// format 0.0.4, docs/operations.md lists the metrics. What is not known is left out.
[[nodiscard]] std::string metrics_text(const nlohmann::json& status, double disk_free_bytes);

}  // namespace soak::station
