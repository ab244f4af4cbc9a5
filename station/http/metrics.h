// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace soak::station {

/// What soakd knows of the computer beside its status.
struct HostFigures {
  double disk_free_bytes = 0.0;  ///< space that is left for recordings; NaN where it is not known
  double heap_bytes = 0.0;       ///< memory that soakd has in use
};

/// The status document (docs/http-api.md) and the host's figures, as Prometheus reads it: text format 0.0.4,
/// docs/operations.md lists the metrics. What is not known is left out.
[[nodiscard]] std::string metrics_text(const nlohmann::json& status, const HostFigures& host);

}  // namespace soak::station
