// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/select/detail/scaled_rows.h"
#include "base/random.h"

namespace soak::anfis::fuzzy {

/// Memberships to start from: as many rows as clusters are drawn, each with probability proportional to its weight
/// times its squared distance from the nearest row drawn before (k-means++, Arthur & Vassilvitskii 2007); every row
/// belongs mostly to the nearest of them. Distances are those of the antecedents and of the output's deviation from one
/// linear model, each divided by its standard deviation: what one plane explains needs no rules.
[[nodiscard]] Eigen::MatrixXd seeded_memberships(const ScaledRows& rows, const std::vector<int>& antecedents,
                                                 int clusters, base::Random& random);

}  // namespace soak::anfis::fuzzy
