// SPDX-License-Identifier: Apache-2.0
#include "station/fit_job.h"

#include "station/accepted_terms.h"
#include "station/fit_unit.h"
#include "station/reference_rule.h"

namespace soak::station {

base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                              const std::vector<calib::ModelTerm>& terms,
                                              const calib::CurveFitOptions& options, int jobs,
                                              CheckWarnings& check_warnings) {
  auto warnings = check_warnings.of(input);
  if (!warnings) return base::forward_error(warnings);
  const auto since = reference_warnings(catalog, input.references);
  if (!since) return base::forward_error(since);
  warnings->insert(warnings->end(), since->begin(), since->end());
  if (const auto taken = take_terms_off(catalog, terms, input, *warnings); !taken) return base::forward_error(taken);
  return fit_unit(catalog, input, options, jobs, *warnings);
}

}  // namespace soak::station
