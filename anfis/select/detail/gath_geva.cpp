// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/gath_geva.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "anfis/linear/least_squares.h"

namespace soak::anfis::fuzzy {
namespace {

// Least variance where the data themselves do not vary (constant y): keeps densities finite.
constexpr double kLeastVariance = 1e-12;

// Log density of N(mean, variance) at a distance whose square is given, element by element.
Eigen::ArrayXd log_gaussian(const Eigen::ArrayXd& squared_distance, double variance) {
  return -0.5 * squared_distance / variance - 0.5 * std::log(2.0 * std::numbers::pi * variance);
}

// min || sqrt(beta) (phi_e theta - y) || [AH05 eq. 5.28-5.30]
void fit_local_model(const ScaledRows& rows, const Eigen::VectorXd& beta, Cluster& cluster) {
  const Eigen::Index inputs = rows.x.cols();
  const Eigen::VectorXd root = beta.cwiseSqrt();
  Eigen::MatrixXd b(rows.x.rows(), inputs + 1);
  b << root.asDiagonal() * rows.x, root;
  const Eigen::VectorXd theta = least_squares_coefficients(b, root.cwiseProduct(rows.y));
  cluster.gains = theta.head(inputs);
  cluster.offset = theta(inputs);
}

Eigen::VectorXd local_residuals(const ScaledRows& rows, const Cluster& cluster) {
  return (rows.y - rows.x * cluster.gains).array() - cluster.offset;
}

std::vector<Cluster> clusters_of(const ScaledRows& rows, const Eigen::MatrixXd& memberships,
                                 const VarianceFloors& floors) {
  std::vector<Cluster> clusters;
  for (Eigen::Index i = 0; i < memberships.cols(); ++i) {
    clusters.push_back(cluster_of(rows, memberships.col(i), floors));
  }
  return clusters;
}

// The cluster with the fewest rows, if these are too few for a local model; else -1.
Eigen::Index collapsed(const ScaledRows& rows, const Eigen::MatrixXd& memberships) {
  Eigen::Index smallest = 0;
  const double mass = (memberships.transpose() * rows.weight).minCoeff(&smallest);
  return memberships.cols() > 1 && mass < static_cast<double>(rows.x.cols() + 2) ? smallest : -1;
}

// Takes a cluster out; its rows go to the others in the ratio of what they had there.
void drop_cluster(Eigen::Index dropped, Clustering& clustering) {
  Eigen::MatrixXd& mu = clustering.memberships;
  const Eigen::Index rest = mu.cols() - 1;
  mu.col(dropped).swap(mu.col(rest));
  mu.conservativeResize(Eigen::NoChange, rest);
  // A row that belonged to the dropped cluster alone is shared equally.
  const Eigen::ArrayXd sum = mu.rowwise().sum();
  mu = (sum > 0.0).replicate(1, rest).select(mu.array().colwise() / sum, 1.0 / static_cast<double>(rest));
  ++clustering.summary.dropped;
}

// Drops clusters, the smallest first, until each can carry a local model. Whether there were any.
bool drop_collapsed(const ScaledRows& rows, Clustering& clustering) {
  const int before = clustering.summary.dropped;
  for (Eigen::Index i = collapsed(rows, clustering.memberships); i >= 0; i = collapsed(rows, clustering.memberships)) {
    drop_cluster(i, clustering);
  }
  return clustering.summary.dropped > before;
}

}  // namespace

VarianceFloors variance_floors(const ScaledRows& rows, const ClusteringOptions& options) {
  return {(options.input_variance_floor * weighted_variances(rows.x, rows.weight)).cwiseMax(kLeastVariance),
          std::max(options.output_variance_floor * weighted_variances(rows.y, rows.weight)(0), kLeastVariance)};
}

Cluster cluster_of(const ScaledRows& rows, const Eigen::Ref<const Eigen::VectorXd>& mu, const VarianceFloors& floors) {
  const Eigen::VectorXd beta = mu.cwiseProduct(rows.weight);
  const double mass = beta.sum();
  Cluster cluster;
  cluster.prior = mass / rows.weight.sum();
  // [AH05 eq. 5.27] v = sum mu x / sum mu, sigma^2 = sum mu (x - v)^2 / sum mu
  cluster.centre = rows.x.transpose() * beta / mass;
  cluster.variance =
      ((rows.x.rowwise() - cluster.centre.transpose()).array().square().matrix().transpose() * beta / mass)
          .cwiseMax(floors.input);
  fit_local_model(rows, beta, cluster);
  // [AH05 eq. 5.31] sigma_i^2 = sum mu (y - f)^2 / sum mu
  cluster.output_variance =
      std::max(local_residuals(rows, cluster).array().square().matrix().dot(beta) / mass, floors.output);
  return cluster;
}

Eigen::MatrixXd log_closeness(const ScaledRows& rows, const std::vector<Cluster>& clusters,
                              const std::vector<int>& antecedents) {
  Eigen::MatrixXd closeness(rows.x.rows(), static_cast<Eigen::Index>(clusters.size()));
  for (Eigen::Index i = 0; i < closeness.cols(); ++i) {
    const Cluster& cluster = clusters[static_cast<std::size_t>(i)];
    // [AH05 eq. 5.32, corrected] 1/D^2 = alpha prod_j N(x_j; v_j, sigma_j^2) N(y; f, sigma^2)
    Eigen::ArrayXd sum = log_gaussian(local_residuals(rows, cluster).array().square(), cluster.output_variance);
    for (const int j : antecedents) {
      sum += log_gaussian((rows.x.col(j).array() - cluster.centre(j)).square(), cluster.variance(j));
    }
    closeness.col(i) = sum + std::log(cluster.prior);
  }
  return closeness;
}

Partition partition(const Eigen::MatrixXd& log_closeness, const Eigen::VectorXd& weight) {
  Partition result;
  const Eigen::VectorXd nearest = log_closeness.rowwise().maxCoeff();
  // [AH05 eq. 5.33, corrected] mu_i = 1 / sum_l (D_i/D_l)^2 = D_i^-2 / sum_l D_l^-2
  result.memberships = (log_closeness.colwise() - nearest).array().exp();
  const Eigen::VectorXd sum = result.memberships.rowwise().sum();
  result.memberships.array().colwise() /= sum.array();
  result.log_likelihood = (nearest.array() + sum.array().log()).matrix().dot(weight) / weight.sum();
  return result;
}

Clustering alternate(const ScaledRows& rows, Eigen::MatrixXd memberships, const ClusteringOptions& options,
                     const VarianceFloors& floors) {
  Clustering result;
  result.memberships = std::move(memberships);
  drop_collapsed(rows, result);
  result.clusters = clusters_of(rows, result.memberships, floors);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    Partition next = partition(log_closeness(rows, result.clusters, options.antecedents), rows.weight);
    const double change = (next.memberships - result.memberships).cwiseAbs().maxCoeff();
    result.memberships = std::move(next.memberships);
    result.summary.log_likelihood.push_back(next.log_likelihood);
    const bool dropped = drop_collapsed(rows, result);
    if (!dropped && change <= options.tolerance) {  // [AH05 eq. 5.34]
      result.summary.stop = ClusteringStop::converged;
      break;
    }
    result.clusters = clusters_of(rows, result.memberships, floors);
  }
  return result;
}

}  // namespace soak::anfis::fuzzy
