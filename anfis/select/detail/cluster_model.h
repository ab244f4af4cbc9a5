// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/select/fuzzy_clustering.h"

namespace soak::anfis::fuzzy {

/// One rule per cluster, in their order: a Gaussian membership per antecedent with the cluster's centre and standard
/// deviation, kAny for the other inputs, which have no memberships. Consequents are 0. Refuses what scatter_rules()
/// refuses: numbers that differ too much in size.
[[nodiscard]] base::Result<Model> cluster_model(const TrainingData& data, const Clustering& clustering,
                                                const std::vector<int>& antecedents);

/// Gives all rules the consequents that together fit the data best, by whitened least squares over the firing strengths
/// [AH05 eq. 5.12-5.13]; dropped gains stay 0.
void solve_consequents(const TrainingData& data, Model& model);

}  // namespace soak::anfis::fuzzy
