// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What a model was fitted to, beside what a fit of all runs of its unit would take now.
struct FittedRuns {
  std::vector<std::string>
      left_out;          ///< "R01 of campaign week-1": what such a fit would take and the model has not seen
  std::size_t gone = 0;  ///< runs of the model that it would not take: void as a whole, or not there
};

/// Compares the runs themselves, whenever they were entered: by the content hash, and where that is another one by
/// their samples (calib::leave_out_copies), as a fit takes copies once. Fails as Catalog::segments() does.
[[nodiscard]] base::Result<FittedRuns> compare_fitted_runs(const db::Catalog& catalog,
                                                           const calib::Calibration& calibration);

}  // namespace soak::station
