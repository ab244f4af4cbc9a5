// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "calib/gap/campaign/campaign.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// The runs of `input`, each with what its file logged between the segments; `with_samples`: samples are looked at for
/// what means do not show, sensor by sensor. Fails (corrupt) where a run file cannot be read.
[[nodiscard]] base::Result<calib::gap::LoggedCampaign> with_logs(const db::Catalog& catalog, calib::UnitInput input,
                                                                 bool with_samples);

/// The runs that a fit of the unit takes (load_unit()), each with its log and its samples looked at. Fails as
/// load_unit() and with_logs() do.
[[nodiscard]] base::Result<calib::gap::LoggedCampaign> load_logged_campaign(const db::Catalog& catalog,
                                                                            const std::string& unit,
                                                                            const std::optional<std::string>& campaign);

}  // namespace soak::station
