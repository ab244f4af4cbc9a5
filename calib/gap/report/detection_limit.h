// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// RMS of a term of one parameter, changing from visit to visit, that stands at the gate of a search in one sensor
/// (scatter then decides, half to half); SI. Nothing for a sensor without readings, and where nothing was searched.
[[nodiscard]] std::optional<double> detection_limit(const CampaignModel& model, std::size_t s,
                                                    const SearchResult& found);

}  // namespace soak::calib::gap
