// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "anfis/data/training_data.h"
#include "base/result.h"
#include "calib/curve/families.h"

namespace soak::calib {

/// What the ANFIS learns from.
struct AnfisRows {
  const anfis::TrainingData& all;
  const Curve& shape;    ///< a curve of all rows, along which they are condensed
  std::set<int> judges;  ///< runs that can judge a curve
};

/// Chooses the rules of the ANFIS by `choice` (or takes options.rules), trains it on the condensed rows and puts it
/// into `trained`, with its candidates where a whole fit has judged them. `left_out`: of an outer fold, else null; then
/// the whole fit has an ANFIS. Refuses too few temperatures.
[[nodiscard]] base::Status train_anfis(const AnfisRows& rows, const CurveFitOptions& options, RuleChoice choice,
                                       const LeftOut* left_out, TrainedFamilies& trained);

}  // namespace soak::calib
