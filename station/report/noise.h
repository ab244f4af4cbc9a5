// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Samples of one sensor that a report analyses at most: 5.8 hours at 200 Hz, about a second of work.
inline constexpr std::size_t kMostNoiseSamples = std::size_t{1} << 22U;

/// The section `noise` of a report: for each sensor the document of `soak signal allan` of the unit's longest segment
/// at rest in this epoch (still_segment.h), from its first kMostNoiseSamples samples. `reason` says why there is
/// nothing where there is nothing. `progress` is told the share that is done, and stops the work (internal) where it
/// returns false.
[[nodiscard]] base::Result<nlohmann::json> noise_json(const db::Catalog& catalog, const std::string& unit,
                                                      std::int32_t epoch, const std::function<bool(double)>& progress);

}  // namespace soak::station
