// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "anfis/linear/condensed_rows.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// For each group, in rising order of their ids: the shape error of its means at each input (shape_rmse()) that the
/// model would have on it had it learned from the other groups alone. Nothing is trained: one Gauss-Newton step in all
/// parameters leads from the model of all groups to that without group g [one-step deletion: Pregibon 1981; as a
/// criterion: Stone 1977],
///     f_-g = f - J H_-g^-1 J_g^T V_g^-1 r_g,   H_-g = J^T V^-1 J - J_g^T V_g^-1 J_g + P,
/// J the Jacobian of the curve, J_g that at the inputs of group g, P the price of curvature. A group that visits inputs
/// which no other one does is judged by what the others say of them.
///
/// Other than an information criterion it asks the groups themselves how far they scatter about the curve: what they
/// share, and no curve follows, costs nothing; noise that wanders within a group costs what it does.
///
/// `model` was trained on `data.rows` with the same smoothness. Refuses (bad_input) fewer than two groups, and models
/// and data that PredictionVariance::of() refuses but for too few rows.
[[nodiscard]] base::Result<std::vector<double>> deleted_group_errors(const Model& model, const CondensedRows& data,
                                                                     double smoothness);

}  // namespace soak::anfis
