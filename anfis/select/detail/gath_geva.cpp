// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/gath_geva.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>

#include "anfis/linear/least_squares.h"

namespace soak::anfis::fuzzy {
namespace {

Scale scale_between(double low, double high) {
  return {0.5 * low + 0.5 * high, high > low ? 0.5 * high - 0.5 * low : 1.0};
}

Eigen::VectorXd mean_one_weights(const TrainingData& data) {
  const auto rows = static_cast<Eigen::Index>(data.rows());
  if (data.weight.empty()) return Eigen::VectorXd::Ones(rows);
  // Divided by the largest first: the sum of weights near the largest double would overflow.
  Eigen::VectorXd weight = Eigen::Map<const Eigen::VectorXd>(data.weight.data(), rows);
  weight /= weight.maxCoeff();
  return weight / weight.mean();
}

struct GroupSum {
  double weight = 0.0;
  double residual = 0.0;  ///< weighted
};

// Residuals of generalised least squares on all inputs and a constant. Free offsets have no constant beside them: its
// column would whiten to rounding errors, which least squares takes for a direction.
Eigen::VectorXd linear_residuals(const TrainingData& data, const ScaledRows& rows) {
  Eigen::MatrixXd a = rows.x;
  if (std::isfinite(data.group_variance)) {
    a.conservativeResize(Eigen::NoChange, a.cols() + 1);
    a.rightCols(1).setOnes();
  }
  const GroupWhitening whitening(data);
  Eigen::MatrixXd whitened = a;
  Eigen::VectorXd y = rows.y;
  whitening.apply(whitened);
  whitening.apply(y);
  return rows.y - a * least_squares_coefficients(whitened, y);
}

void remove_group_offsets(const TrainingData& data, ScaledRows& rows) {
  const Eigen::VectorXd residual = linear_residuals(data, rows);
  std::map<int, GroupSum> sums;
  for (std::size_t k = 0; k < data.rows(); ++k) {
    const double weight = data.weight.empty() ? 1.0 : data.weight[k];
    sums[data.group[k]].weight += weight;
    sums[data.group[k]].residual += weight * residual(static_cast<Eigen::Index>(k));
  }
  // b_g = s^2 sum w r / (1 + s^2 sum w), in the limit the weighted mean
  for (std::size_t k = 0; k < data.rows(); ++k) {
    const GroupSum& sum = sums[data.group[k]];
    rows.y(static_cast<Eigen::Index>(k)) -= sum.residual / (1.0 / data.group_variance + sum.weight);
  }
}

// Share of a row's membership that goes to the nearest seed; the rest is spread equally, so that the local model of a
// seed with few rows around it still has rows to stand on.
constexpr double kNearestShare = 0.9;

Eigen::VectorXd deviation_from_plane(const ScaledRows& rows) {
  const Eigen::VectorXd root = rows.weight.cwiseSqrt();
  Eigen::MatrixXd a(rows.x.rows(), rows.x.cols() + 1);
  a << rows.x, Eigen::VectorXd::Ones(rows.x.rows());
  return rows.y - a * least_squares_coefficients(root.asDiagonal() * a, root.cwiseProduct(rows.y));
}

// One row per row of data: what distances are measured in.
Eigen::MatrixXd features(const ScaledRows& rows, const std::vector<int>& antecedents) {
  Eigen::MatrixXd z(rows.x.rows(), static_cast<Eigen::Index>(antecedents.size()) + 1);
  for (std::size_t j = 0; j < antecedents.size(); ++j) z.col(static_cast<Eigen::Index>(j)) = rows.x.col(antecedents[j]);
  z.rightCols(1) = deviation_from_plane(rows);
  const Eigen::VectorXd variance = weighted_variances(z, rows.weight);
  for (Eigen::Index j = 0; j < z.cols(); ++j) z.col(j) *= variance(j) > 0.0 ? 1.0 / std::sqrt(variance(j)) : 0.0;
  return z;
}

// A row drawn with probability proportional to its share; the last one where all shares are 0.
Eigen::Index drawn(const Eigen::VectorXd& share, base::Random& random) {
  double rest = random.uniform() * share.sum();
  for (Eigen::Index k = 0; k + 1 < share.size(); ++k) {
    rest -= share(k);
    if (rest < 0.0) return k;
  }
  return share.size() - 1;
}

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

Scales scales_of(const TrainingData& data) {
  Scales scales;
  for (std::size_t j = 0; j < data.inputs; ++j) {
    double low = data.x[j];
    double high = data.x[j];
    for (std::size_t k = 0; k < data.rows(); ++k) {
      low = std::min(low, data.row(k)[j]);
      high = std::max(high, data.row(k)[j]);
    }
    scales.inputs.push_back(scale_between(low, high));
  }
  const auto [low, high] = std::minmax_element(data.y.begin(), data.y.end());
  scales.output = scale_between(*low, *high);
  return scales;
}

ScaledRows scaled_rows(const TrainingData& data, const Scales& scales) {
  const auto count = static_cast<Eigen::Index>(data.rows());
  ScaledRows rows{Eigen::MatrixXd(count, static_cast<Eigen::Index>(data.inputs)), Eigen::VectorXd(count),
                  mean_one_weights(data)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto row = data.row(static_cast<std::size_t>(k));
    for (std::size_t j = 0; j < data.inputs; ++j) {
      rows.x(k, static_cast<Eigen::Index>(j)) = scales.inputs[j].scaled(row[j]);
    }
    rows.y(k) = scales.output.scaled(data.y[static_cast<std::size_t>(k)]);
  }
  if (data.group_variance > 0.0) remove_group_offsets(data, rows);
  return rows;
}

Eigen::VectorXd weighted_variances(const Eigen::Ref<const Eigen::MatrixXd>& values, const Eigen::VectorXd& weight) {
  const Eigen::RowVectorXd mean = weight.transpose() * values / weight.sum();
  return (values.rowwise() - mean).array().square().matrix().transpose() * weight / weight.sum();
}

Eigen::MatrixXd seeded_memberships(const ScaledRows& rows, const std::vector<int>& antecedents, int clusters,
                                   base::Random& random) {
  const Eigen::MatrixXd z = features(rows, antecedents);
  Eigen::MatrixXd squared_distance(z.rows(), clusters);
  Eigen::VectorXd share = rows.weight;
  for (Eigen::Index i = 0; i < clusters; ++i) {
    squared_distance.col(i) = (z.rowwise() - z.row(drawn(share, random)).eval()).rowwise().squaredNorm();
    share = rows.weight.cwiseProduct(squared_distance.leftCols(i + 1).rowwise().minCoeff());
  }
  Eigen::MatrixXd memberships =
      Eigen::MatrixXd::Constant(z.rows(), clusters, (1.0 - kNearestShare) / static_cast<double>(clusters));
  for (Eigen::Index k = 0; k < z.rows(); ++k) {
    Eigen::Index nearest = 0;
    squared_distance.row(k).minCoeff(&nearest);
    memberships(k, nearest) += kNearestShare;
  }
  return memberships;
}

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
