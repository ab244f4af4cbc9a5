// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "nav/drive/drive.h"
#include "nav/outages/fix_statistics.h"
#include "nav/outages/outage_runner.h"

namespace soak::station {

/// {"value", "ci95"}; `ci95` is null where there is no interval.
[[nodiscard]] nlohmann::json estimate_json(const nav::Estimate& estimate);

/// A comparison of pipelines on outages (docs/schema/nav-outages.schema.json): {"length_s", "seed", "drives",
/// "pipelines", "outages"}. `fixes`: of each drive. Intervals are null where there are fewer than 5 outages.
[[nodiscard]] nlohmann::json comparison_json(std::span<const nav::Drive> drives,
                                             std::span<const nav::Innovations> fixes,
                                             std::span<const nav::OutageResult> results,
                                             std::span<const nav::Pipeline> pipelines, double length_s,
                                             std::size_t seed);

/// What must be known of a comparison beside its figures, as sentences: what the calibration left raw, what an ANFIS
/// learnt that is judged; of recorded drives what the truth is and how good the fixes are.
[[nodiscard]] std::vector<std::string> outage_remarks(const nlohmann::json& comparison);

/// The same as a table of pipelines; with outage_remarks().
[[nodiscard]] std::string comparison_text(const nlohmann::json& comparison);

}  // namespace soak::station
