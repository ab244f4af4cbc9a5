// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "base/random.h"

namespace soak::anfis {
namespace {

const std::vector<int> kGroup = {3, 7, 3, 3, 7, 9, 7, 3};  // interleaved, one of a single row
const std::vector<double> kWeight = {1.0, 0.5, 4.0, 2.0, 0.1, 3.0, 1.5, 0.7};

Eigen::MatrixXd whitening_matrix(const GroupWhitening& whitening) {
  const auto n = static_cast<Eigen::Index>(whitening.rows());
  Eigen::MatrixXd l = Eigen::MatrixXd::Identity(n, n);
  whitening.apply(l);
  return l;
}

Eigen::MatrixXd dense_covariance(std::span<const double> weight, double group_variance) {
  const auto n = static_cast<Eigen::Index>(kGroup.size());
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    v(i, i) = weight.empty() ? 1.0 : 1.0 / weight[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < n; ++k) {
      v(i, k) += kGroup[static_cast<std::size_t>(i)] == kGroup[static_cast<std::size_t>(k)] ? group_variance : 0.0;
    }
  }
  return v;
}

TEST(GroupWhitening, SquaresToTheInverseOfTheDenseCovariance) {
  for (const double group_variance : {0.0, 0.3, 25.0}) {
    for (const bool weighted : {false, true}) {
      const std::vector<double> weight = weighted ? kWeight : std::vector<double>{};
      const Eigen::MatrixXd l = whitening_matrix(GroupWhitening(kGroup.size(), weight, kGroup, group_variance));
      const Eigen::MatrixXd expected = dense_covariance(weight, group_variance).inverse();
      EXPECT_LT((l.transpose() * l - expected).cwiseAbs().maxCoeff(), 1e-13) << group_variance;
    }
  }
}

TEST(GroupWhitening, TransposedApplicationIsTheTranspose) {
  const GroupWhitening whitening(kGroup.size(), kWeight, kGroup, 2.0);
  const Eigen::MatrixXd l = whitening_matrix(whitening);
  Eigen::MatrixXd transposed = Eigen::MatrixXd::Identity(l.rows(), l.cols());
  whitening.apply_transposed(transposed);
  EXPECT_LT((l.transpose() - transposed).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(GroupWhitening, InfiniteGroupVarianceIsTheLimitAndRemovesEachGroupsWeightedMean) {
  const GroupWhitening fixed(kGroup.size(), kWeight, kGroup, std::numeric_limits<double>::infinity());
  const Eigen::MatrixXd l = whitening_matrix(fixed);
  const Eigen::MatrixXd limit = dense_covariance(kWeight, 1e6).inverse();  // differs by about 1 / (1e6 group weight)
  EXPECT_LT((l.transpose() * l - limit).cwiseAbs().maxCoeff(), 1e-4);
  Eigen::VectorXd offsets(8);
  for (Eigen::Index i = 0; i < 8; ++i) {
    offsets(i) = 10.0 * kGroup[static_cast<std::size_t>(i)];
  }
  fixed.apply(offsets);
  EXPECT_LT(offsets.cwiseAbs().maxCoeff(), 1e-13);
}

TEST(GroupWhitening, WithoutGroupsItScalesByTheRootOfTheWeight) {
  Eigen::VectorXd values = Eigen::VectorXd::Constant(8, 2.0);
  const GroupWhitening whitening(8, kWeight, {}, 0.0);
  whitening.apply(values);
  for (Eigen::Index i = 0; i < 8; ++i) {
    EXPECT_DOUBLE_EQ(values(i), 2.0 * std::sqrt(kWeight[static_cast<std::size_t>(i)]));
  }
  EXPECT_DOUBLE_EQ(whitening.total_weight(), 12.8);
}

}  // namespace
}  // namespace soak::anfis
