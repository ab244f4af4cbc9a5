// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/separability.h"

#include <cmath>

#include "base/linear/dense_solve.h"

namespace soak::anfis::fuzzy {

ClassCovariances class_covariances(const std::vector<Cluster>& clusters) {
  const Eigen::Index inputs = clusters.front().centre.size();
  // The corrected [AH05 eq. 5.37]: v_0 = sum_i p(eta_i) v_i; the print has no v_i. Priors sum to 1.
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(inputs);
  for (const Cluster& cluster : clusters) {
    mean += cluster.prior * cluster.centre;
  }
  ClassCovariances f{Eigen::MatrixXd::Zero(inputs, inputs), Eigen::VectorXd::Zero(inputs)};
  for (const Cluster& cluster : clusters) {
    f.between += cluster.prior * (cluster.centre - mean) * (cluster.centre - mean).transpose();
    f.within += cluster.prior * cluster.variance;
  }
  return f;
}

double log_separability(const ClassCovariances& covariances, const std::vector<int>& inputs) {
  const Eigen::VectorXd scale = covariances.within(inputs).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd total =
      Eigen::MatrixXd(scale.asDiagonal() * covariances.between(inputs, inputs) * scale.asDiagonal()) +
      Eigen::MatrixXd::Identity(scale.size(), scale.size());
  return 2.0 * base::cholesky(total).diagonal().array().log().sum();
}

std::vector<int> without(std::vector<int> inputs, int left_out) {
  std::erase(inputs, left_out);
  return inputs;
}

int least_needed(const ClassCovariances& covariances, const std::vector<int>& inputs) {
  int least = inputs.front();
  double most_left = -1.0;
  for (const int candidate : inputs) {
    if (const double left = log_separability(covariances, without(inputs, candidate)); left >= most_left) {
      most_left = left;
      least = candidate;
    }
  }
  return least;
}

}  // namespace soak::anfis::fuzzy
