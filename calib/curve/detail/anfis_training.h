// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "anfis/linear/condensed_rows.h"
#include "base/result.h"
#include "calib/curve/families.h"

namespace soak::calib {

/// Chooses the rules of the ANFIS by `choice` (or takes options.rules), trains it on the condensed rows and puts it
/// into `trained`, with its candidates where a whole fit has judged them. `range_c`: least and largest temperature that
/// the curve is for. `left_out`: of an outer fold, else null; then the whole fit has an ANFIS. Refuses too few
/// temperatures.
[[nodiscard]] base::Status train_anfis(const std::pair<double, double>& range_c, const anfis::CondensedRows& rows,
                                       const CurveFitOptions& options, RuleChoice choice, const LeftOut* left_out,
                                       TrainedFamilies& trained);

}  // namespace soak::calib
