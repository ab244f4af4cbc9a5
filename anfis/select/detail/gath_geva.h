// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/random.h"

namespace soak::anfis::fuzzy {

/// Units in which rows span [-1, 1]. Where y is constant its half range is 1.
struct Scales {
  std::vector<Scale> inputs;
  Scale output;
};
[[nodiscard]] Scales scales_of(const TrainingData& data);

/// Training data as clustering sees them.
struct ScaledRows {
  Eigen::MatrixXd x;       ///< rows x inputs, scaled
  Eigen::VectorXd y;       ///< scaled, without the groups' offsets
  Eigen::VectorXd weight;  ///< positive, mean 1
};

/// The offset of a group is the weighted mean of its residuals from one linear model of all rows (generalised least
/// squares), shrunk by group_variance. Free offsets take the level of y with them.
[[nodiscard]] ScaledRows scaled_rows(const TrainingData& data, const Scales& scales);

/// Weighted variance of each column.
[[nodiscard]] Eigen::VectorXd weighted_variances(const Eigen::Ref<const Eigen::MatrixXd>& values,
                                                 const Eigen::VectorXd& weight);

/// Memberships to start from: as many rows as clusters are drawn, each with probability proportional to its weight
/// times its squared distance from the nearest row drawn before (k-means++, Arthur & Vassilvitskii 2007); every row
/// belongs mostly to the nearest of them. Distances are those of the antecedents and of the output's deviation from one
/// linear model, each divided by its standard deviation: what one plane explains needs no rules.
[[nodiscard]] Eigen::MatrixXd seeded_memberships(const ScaledRows& rows, const std::vector<int>& antecedents,
                                                 int clusters, base::Random& random);

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
