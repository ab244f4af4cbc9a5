// SPDX-License-Identifier: Apache-2.0
#include "station/fit/check_warnings.h"

#include <set>

#include "station/records/check_standard.h"

namespace soak::station {

base::Result<std::vector<calib::Warning>> CheckWarnings::of_campaign(const std::string& campaign) {
  const auto known = known_.find(campaign);
  if (known != known_.end()) return known->second;
  const auto verdicts = check_standard_of(catalog_, campaign);
  if (!verdicts) return base::forward_error(verdicts);
  std::vector<calib::Warning> warnings;
  for (const CheckVerdict& verdict : *verdicts) {
    if (auto warning = warning_of(verdict)) warnings.push_back(*std::move(warning));
  }
  return known_.emplace(campaign, std::move(warnings)).first->second;
}

base::Result<std::vector<calib::Warning>> CheckWarnings::of(const calib::UnitInput& input) {
  std::set<std::string> campaigns;
  for (const calib::RunInput& run : input.runs) campaigns.insert(run.campaign);
  std::vector<calib::Warning> all;
  for (const std::string& campaign : campaigns) {
    const auto warnings = of_campaign(campaign);
    if (!warnings) return base::forward_error(warnings);
    all.insert(all.end(), warnings->begin(), warnings->end());
  }
  return all;
}

}  // namespace soak::station
