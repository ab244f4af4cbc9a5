// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calib/vocabulary/segment.h"
#include "db/catalog/catalog.h"
#include "db/run/sample.h"

/// Stored runs and their parts as they stand in JSON results: of `soak runs` and of the HTTP interface.
namespace soak::station {

[[nodiscard]] nlohmann::json stored_run_json(const db::RunRow& run);
[[nodiscard]] nlohmann::json stored_channel_json(const db::ChannelInfo& channel);
/// Means and standard errors in printed units: deg/s, m/s².
[[nodiscard]] nlohmann::json stored_segment_json(const calib::Segment& segment);
[[nodiscard]] nlohmann::json stored_void_json(const db::VoidRecord& record);

}  // namespace soak::station
