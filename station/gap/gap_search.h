// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/gap/campaign/campaign.h"
#include "calib/gap/report/gap_report.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A search for what the newest model of a unit lacks.
struct GapSearch {
  db::ModelRow model;
  std::vector<calib::ModelTerm> terms;  ///< that the model carries
  calib::gap::LoggedCampaign campaign;  ///< less the terms
  calib::gap::GapReport report;
  std::vector<std::string> not_taken_off;  ///< sentences: terms that some run cannot evaluate
};

/// Looks in the runs that a fit takes, of one campaign where it is given. Refuses (bad_input) an unknown unit, and one
/// without a model of its present epoch.
[[nodiscard]] base::Result<GapSearch> search_gap(const db::Catalog& catalog, const std::string& unit,
                                                 const std::optional<std::string>& campaign);

}  // namespace soak::station
