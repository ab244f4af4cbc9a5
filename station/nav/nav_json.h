// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "nav/drive/drive.h"
#include "nav/outages/outage_runner.h"

namespace soak::station {

/// A comparison of pipelines on outages (docs/schema/nav-outages.schema.json): {"length_s", "seed", "drives",
/// "pipelines", "outages"}. Intervals are null where there are fewer than 5 outages.
[[nodiscard]] nlohmann::json comparison_json(std::span<const nav::Drive> drives,
                                             std::span<const nav::OutageResult> results,
                                             std::span<const nav::Pipeline> pipelines, double length_s,
                                             std::size_t seed);

/// The same as a table of pipelines; with "uncorrected" (docs/schema) which sensors the calibration left raw.
[[nodiscard]] std::string comparison_text(const nlohmann::json& comparison);

}  // namespace soak::station
