// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What the check standards say of the campaigns of units that are fitted one after the other: each campaign is looked
/// at once, as its charts take all runs of the standard.
class CheckWarnings {
 public:
  explicit CheckWarnings(const db::Catalog& catalog) : catalog_(catalog) {}

  /// Of the campaigns of the unit's runs.
  [[nodiscard]] base::Result<std::vector<calib::Warning>> of(const calib::UnitInput& input);

 private:
  base::Result<std::vector<calib::Warning>> of_campaign(const std::string& campaign);

  const db::Catalog& catalog_;
  std::map<std::string, std::vector<calib::Warning>> known_;
};

}  // namespace soak::station
