// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// How cluster_takagi_sugeno() clusters.
struct ClusteringOptions {
  int clusters = 4;                     ///< 1..256, at most the number of distinct rows of x
  std::vector<int> antecedents;         ///< inputs that distances look at (x_k of [AH05 eq. 5.24]), rising; empty: all
  double input_variance_floor = 0.01;   ///< least variance of a cluster along an input, share of the data's; (0, 1]
  double output_variance_floor = 1e-6;  ///< least sigma_i^2, share of the variance of y; (0, 1]
  int iterations = 100;                 ///< most iterations of each start, >= 1
  double tolerance = 1e-3;              ///< epsilon of [AH05 eq. 5.34]: stop when no membership changes by more; (0, 1)
  int starts = 5;                       ///< seeded starts, >= 1; the one with the largest likelihood is kept
  std::uint64_t seed = 1;

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// One cluster: where it lies, and the local linear model that holds there. In scaled units.
struct Cluster {
  double prior = 0.0;            ///< alpha_i = p(eta_i): weighted share of the rows
  Eigen::VectorXd centre;        ///< v_ij, one per input, also those that are no antecedents
  Eigen::VectorXd variance;      ///< sigma_ij^2, one per input, not below the floor
  Eigen::VectorXd gains;         ///< theta_i, one per input
  double offset = 0.0;           ///< theta_i, the unit column
  double output_variance = 0.0;  ///< sigma_i^2, not below the floor
};

/// Why a clustering stopped.
enum class ClusteringStop {
  converged,        ///< no membership changes by more than the tolerance
  iterations_done,  ///< all iterations made
};

/// "converged", "iterations done".
[[nodiscard]] std::string_view name(ClusteringStop stop);

/// What happened in a clustering.
struct ClusteringSummary {
  ClusteringStop stop = ClusteringStop::iterations_done;
  int start = 0;                       ///< from 1: the start that was kept; 0 where clusters were given
  int dropped = 0;                     ///< clusters that collapsed in it
  std::vector<double> log_likelihood;  ///< in each iteration of it, mean over rows

  [[nodiscard]] std::string one_line() const;
};

/// A fuzzy partition and its clusters.
struct Clustering {
  std::vector<Scale> inputs;  ///< scaled units of the clusters: rows span [-1, 1]
  Scale output;
  std::vector<Cluster> clusters;  ///< at least one, in rising order of their centres along the first antecedent
  Eigen::MatrixXd memberships;    ///< U: mu_ik, rows x clusters; every row sums to 1 [AH05 eq. 5.26]
  ClusteringSummary summary;
};

/// Modified Gath-Geva clustering that identifies a Takagi-Sugeno model [AH05 §5.4.1; Abonyi, Babuska & Szeifert 2002]:
/// expectation maximisation of a mixture of clusters, each an axis-parallel Gaussian over the antecedents times a
/// Gaussian around a local linear model of all inputs,
///     1/D_ik^2 = alpha_i prod_j N(x_jk; v_ij, sigma_ij^2) N(y_k; theta_i . [phi_k 1], sigma_i^2).
/// In turns: memberships mu_ik = 1 / sum_l (D_ik/D_lk)^(2/(m-1)) with m = 2, which is the posterior probability of the
/// cluster; then centres and variances [eq. 5.27], local models by weighted least squares [eq. 5.28-5.30] (rank
/// revealing, not by the normal equations of the print) and output variances [eq. 5.31]. The mean log-likelihood
/// log sum_i 1/D_ik^2 never falls, and it is the objective that chooses among starts.
///
/// The print of eq. 5.32 lacks alpha_i and the norms of the input Gaussians, and in the second exponential the factor
/// 2 sigma_i^2 has slipped to sqrt(2 pi sigma_i^2); eq. 5.33 sums over the cluster that it divides by, and in it D^2
/// stands where D should; eq. 5.25 and 5.34 are as intended. Distances are computed as logarithms.
///
/// Row weights count as multiplicities (only their ratios matter). A group's random offset, estimated with one linear
/// model of all rows, is taken from y first; where offsets are free (infinite group_variance) the level goes with them
/// and the offsets of clusters hold without it. A cluster whose memberships sum to less than inputs + 2 rows cannot
/// carry a local model: it is dropped, and its rows go to the others. One cluster always remains. The same arguments
/// give the same bits.
///
/// Refuses (bad_input) options out of range, antecedents that the data do not have, and data that validate() refuses or
/// that have fewer distinct rows than clusters.
[[nodiscard]] base::Result<Clustering> cluster_takagi_sugeno(const TrainingData& data,
                                                             const ClusteringOptions& options = {});

/// The same from given clusters (of other rows, or with other antecedents) instead of seeded starts: options.clusters,
/// starts and seed are not used. The scales stay those of `initial`, which must have clusters and as many inputs as
/// data.
[[nodiscard]] base::Result<Clustering> refine_clusters(const TrainingData& data, const Clustering& initial,
                                                       const ClusteringOptions& options);

}  // namespace soak::anfis
