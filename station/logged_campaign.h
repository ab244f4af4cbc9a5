// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "calib/gap/campaign.h"
#include "db/catalog.h"

namespace soak::station {

/// The runs that a fit of the unit takes (load_unit()), each with what its file logged between the segments. Fails as
/// load_unit() does, and where a run file cannot be read (corrupt). Samples are looked at for what means do not show,
/// sensor by sensor.
[[nodiscard]] base::Result<calib::gap::LoggedCampaign> load_logged_campaign(const db::Catalog& catalog,
                                                                            const std::string& unit,
                                                                            const std::optional<std::string>& campaign);

}  // namespace soak::station
