// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// What is left when `effects` have been added to `model`, and whether it forbids their names. `typical`: median
/// heterogeneity of the library; `price`: of one parameter. The first of these that holds:
/// - a second effect of the temperature history that is a twin of one before it, in sensors of that one, and takes
///   less than half as much there, or the same share in each of three or more: one mechanism between the two, and
///   neither;
/// - an axis that finds more than a tenth of what is explained in the sensors of an effect (a twenty-fifth
///   if its regressors have no shape to approximate), under the gate of the search: the mechanism does not fit;
/// - scatter that hangs together in time (slow_noise.h), if that is a quarter of what is named, or more;
/// - an axis in any sensors under the gate of the search, if it is worth a quarter of the best name, or more.
/// If none forbids, the strongest axis under the gate, beside the names.
[[nodiscard]] std::optional<ResidualStructure> find_residual_structure(const CampaignModel& model,
                                                                       const std::vector<NamedEffect>& effects,
                                                                       double typical, double price);

}  // namespace soak::calib::gap
