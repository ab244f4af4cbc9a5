// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/seeding.h"

#include <cmath>
#include <cstddef>

#include "anfis/linear/least_squares.h"

namespace soak::anfis::fuzzy {
namespace {

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
  for (std::size_t j = 0; j < antecedents.size(); ++j) {
    z.col(static_cast<Eigen::Index>(j)) = rows.x.col(antecedents[j]);
  }
  z.rightCols(1) = deviation_from_plane(rows);
  const Eigen::VectorXd variance = weighted_variances(z, rows.weight);
  for (Eigen::Index j = 0; j < z.cols(); ++j) {
    z.col(j) *= variance(j) > 0.0 ? 1.0 / std::sqrt(variance(j)) : 0.0;
  }
  return z;
}

// A row drawn with probability proportional to its share; the last one where all shares are 0.
Eigen::Index drawn(const Eigen::VectorXd& share, base::Random& random) {
  double rest = random.uniform() * share.sum();
  for (Eigen::Index k = 0; k + 1 < share.size(); ++k) {
    rest -= share(k);
    if (rest < 0.0) {
      return k;
    }
  }
  return share.size() - 1;
}

}  // namespace

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

}  // namespace soak::anfis::fuzzy
