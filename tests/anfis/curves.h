// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/select/structure_search.h"
#include "anfis/train/learner.h"

namespace soak::anfis::test {

/// Variable projection with the price of curvature that thermal curves are learned with.
VariableProjectionOptions curve_learner();

/// The same for the candidates of a search: 12 evaluations.
VariableProjectionOptions quick_curve_learner();

/// Search over 2..10 memberships in `folds` folds of groups.
StructureSearch search_curve(const TrainingData& data, int folds, Shape shape);

/// A curve of that many rules.
Model learn_curve(const TrainingData& data, int memberships, Shape shape);

}  // namespace soak::anfis::test
