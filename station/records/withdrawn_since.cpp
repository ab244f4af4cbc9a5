// SPDX-License-Identifier: Apache-2.0
#include "station/records/withdrawn_since.h"

#include "station/fit/reference_rule.h"
#include "station/report/runs_of_model.h"

namespace soak::station {

base::Result<std::vector<calib::Warning>> withdrawn_since(const db::Catalog& catalog,
                                                          const calib::Calibration& calibration) {
  const auto runs = runs_of_model(catalog, calibration);
  if (!runs) return base::forward_error(runs);
  std::vector<calib::Warning> warnings;
  for (const calib::Warning& warning : runs->warnings) {
    if (warning.code == "voided_since") warnings.push_back(warning);
  }
  const auto since = reference_warnings(catalog, calibration.references);
  if (!since) return base::forward_error(since);
  warnings.insert(warnings.end(), since->begin(), since->end());
  return warnings;
}

}  // namespace soak::station
