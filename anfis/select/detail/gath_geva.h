// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/select/detail/scaled_rows.h"
#include "anfis/select/fuzzy_clustering.h"

namespace soak::anfis::fuzzy {

/// Least variances that clusters may have, in scaled units.
struct VarianceFloors {
  Eigen::VectorXd input;  ///< one per input
  double output = 0.0;
};
[[nodiscard]] VarianceFloors variance_floors(const ScaledRows& rows, const ClusteringOptions& options);

/// Parameters of the cluster in which row k has membership mu(k) [AH05 eq. 5.27, 5.30, 5.31]. mu must not be 0 in every
/// row.
[[nodiscard]] Cluster cluster_of(const ScaledRows& rows, const Eigen::Ref<const Eigen::VectorXd>& mu,
                                 const VarianceFloors& floors);

/// log 1/D_ik^2 [AH05 eq. 5.32, corrected], rows x clusters.
[[nodiscard]] Eigen::MatrixXd log_closeness(const ScaledRows& rows, const std::vector<Cluster>& clusters,
                                            const std::vector<int>& antecedents);

/// A partition and how well its clusters describe the rows.
struct Partition {
  Eigen::MatrixXd memberships;  ///< mu_ik [AH05 eq. 5.33, corrected], rows x clusters; every row sums to 1
  double log_likelihood = 0.0;  ///< weighted mean over rows of log sum_i 1/D_ik^2
};
[[nodiscard]] Partition partition(const Eigen::MatrixXd& log_closeness, const Eigen::VectorXd& weight);

/// Alternates partition and clusters from given memberships until one of ClusteringStop. Fills clusters, memberships
/// and summary; scales are the caller's.
[[nodiscard]] Clustering alternate(const ScaledRows& rows, Eigen::MatrixXd memberships,
                                   const ClusteringOptions& options, const VarianceFloors& floors);

}  // namespace soak::anfis::fuzzy
