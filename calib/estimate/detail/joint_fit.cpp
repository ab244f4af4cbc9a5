// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/joint_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace soak::calib::six_position {
namespace {

constexpr int kDriftIterations = 15;

using LocalMatrix = Eigen::Matrix<double, kLocalCount, kLocalCount>;

constexpr double kOpen = 1e-6;  ///< share of an open direction from which an unknown counts as open

Eigen::Index contrast_index(const Problem& problem) { return problem.with_even ? 3 : 2; }

/// Number of shared unknowns. Accelerometer: couplings to the two other axes, then the even-order term, then the
/// contrast of the horizontal faces, then the tilts of the vertical to north and east. Gyro: to its own, then the
/// nuisances.
Eigen::Index shared_count(const Problem& problem) {
  if (!problem.with_position) return 0;
  if (!is_gyro(problem.sensor)) {
    return contrast_index(problem) + (problem.with_contrast ? 1 : 0) + (problem.with_level ? kLevelCount : 0);
  }
  return problem.with_coupling ? 1 + static_cast<Eigen::Index>(problem.nuisance.size()) : 0;
}

LocalVector local_row(const Problem& problem, const Row& row) {
  LocalVector a = LocalVector::Zero();
  a[kBias] = 1.0;
  a[kDrift] = row.tau;
  // Columns are in units of g, so that all unknowns have the size of a reading.
  if (problem.visits[row.visit].with_scale) a[kScale] = row.scale_input;
  return a;
}

Eigen::VectorXd shared_row(const Problem& problem, const Row& row) {
  Eigen::VectorXd a = Eigen::VectorXd::Zero(shared_count(problem));
  if (a.size() == 0) return a;
  const std::size_t axis = axis_of(problem.sensor);
  if (!is_gyro(problem.sensor)) {
    a[0] = row.up[(axis + 1) % 3];
    a[1] = row.up[(axis + 2) % 3];
    // K₂(f² − g²): 0 where the axis is vertical, so that b stays (up + down)/2 and no tilt of the horizontal faces
    // reaches it.
    if (problem.with_even) a[kEven] = row.up[axis] * row.up[axis] - 1.0;
    // What is left of four faces that are not square once M and K₂ have had theirs: it would pass for a drift, the same
    // in every visit, which reaches the level of b.
    if (problem.with_contrast) a[contrast_index(problem)] = a[0] * a[0] - a[1] * a[1];
    if (problem.with_level) a.tail<kLevelCount>() << row.north[axis], row.east[axis];
    return a;
  }
  a[0] = std::abs(row.up[axis]) > kOnAxis ? row.up[axis] : 0.0;
  const auto found = std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label);
  if (found != problem.nuisance.end()) a[1 + (found - problem.nuisance.begin())] = 1.0;
  return a;
}

/// Normal equations of one visit after whitening; the unknowns' sizes are alike, so their condition is small.
struct LocalNormal {
  LocalMatrix own = LocalMatrix::Zero();
  Eigen::MatrixXd cross;
  LocalVector right = LocalVector::Zero();
};

struct Normal {
  std::vector<LocalNormal> local;
  Eigen::MatrixXd shared;
  Eigen::VectorXd shared_right;
};

Normal assemble(const Problem& problem) {
  const Eigen::Index k = shared_count(problem);
  Normal normal{std::vector<LocalNormal>(problem.visits.size()), Eigen::MatrixXd::Zero(k, k), Eigen::VectorXd::Zero(k)};
  for (LocalNormal& local : normal.local) local.cross = Eigen::MatrixXd::Zero(kLocalCount, k);
  for (const Row& row : problem.rows) {
    LocalNormal& local = normal.local[row.visit];
    const LocalVector a = local_row(problem, row);
    const Eigen::VectorXd s = shared_row(problem, row);
    local.own += row.weight * a * a.transpose();
    local.cross += row.weight * a * s.transpose();
    local.right += row.weight * a * row.value;
    normal.shared += row.weight * s * s.transpose();
    normal.shared_right += row.weight * s * row.value;
  }
  return normal;
}

/// Pseudo-inverse of a symmetric matrix; `null` receives the directions without information.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, Eigen::MatrixXd& null) {
  if (matrix.size() == 0) return matrix;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  const double floor = 1e-9 * std::max(1e-300, eigen.eigenvalues().cwiseAbs().maxCoeff());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(matrix.rows());
  std::vector<Eigen::Index> empty;
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (eigen.eigenvalues()[i] > floor) {
      inverse[i] = 1.0 / eigen.eigenvalues()[i];
    } else {
      empty.push_back(i);
    }
  }
  null = eigen.eigenvectors()(Eigen::all, empty);
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

/// The normal equations of the shared unknowns once each visit's own are eliminated (Schur complement).
SharedNormal eliminate_visits(const Problem& problem, const Normal& normal, double drift_variance,
                              std::vector<LocalMatrix>& inverse) {
  const std::size_t n = problem.visits.size();
  inverse.resize(n);
  SharedNormal reduced{normal.shared, normal.shared_right};
  for (std::size_t v = 0; v < n; ++v) {
    LocalMatrix own = normal.local[v].own;
    own(kDrift, kDrift) += 1.0 / drift_variance;
    if (!problem.visits[v].with_scale) own(kScale, kScale) = own(kBias, kBias);
    inverse[v] = own.inverse();
    reduced.matrix -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].cross;
    reduced.right -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].right;
  }
  return reduced;
}

/// Weighted least squares with a drift of variance `drift_variance` per visit: each visit's own unknowns are
/// eliminated, the shared ones solved, the rest substituted back.
Solution solve_with(const Problem& problem, const Normal& normal, double drift_variance) {
  const std::size_t n = problem.visits.size();
  std::vector<LocalMatrix> inverse;
  const SharedNormal reduced = eliminate_visits(problem, normal, drift_variance, inverse);
  Solution solution;
  solution.drift_variance = drift_variance;
  const Eigen::MatrixXd shared_covariance = pseudo_inverse(reduced.matrix, solution.open);
  solution.shared = shared_covariance * reduced.right;
  solution.shared_covariance = shared_covariance;
  for (std::size_t v = 0; v < n; ++v) {
    const Eigen::MatrixXd carry = inverse[v] * normal.local[v].cross;
    solution.local.push_back(inverse[v] * normal.local[v].right - carry * solution.shared);
    solution.local_variance.push_back(
        (LocalMatrix(inverse[v]) + LocalMatrix(carry * shared_covariance * carry.transpose())).diagonal());
    solution.bias_known.push_back(shows(solution, carry.row(kBias).transpose()));
    solution.scale_known.push_back(problem.visits[v].with_scale && shows(solution, carry.row(kScale).transpose()));
  }
  return solution;
}

void judge_residuals(const Problem& problem, Solution& solution, double drift_variance) {
  double chi_squared = 0.0;
  double unknowns = static_cast<double>(shared_count(problem));
  for (const Row& row : problem.rows) {
    const double fitted =
        local_row(problem, row).dot(solution.local[row.visit]) + shared_row(problem, row).dot(solution.shared);
    chi_squared += row.weight * (row.value - fitted) * (row.value - fitted);
  }
  for (std::size_t v = 0; v < problem.visits.size(); ++v) {
    const double drift = solution.local[v][kDrift];
    chi_squared += drift * drift / drift_variance;
    unknowns += problem.visits[v].with_scale ? 2.0 : 1.0;
  }
  const double degrees = static_cast<double>(problem.rows.size()) - unknowns;
  solution.reduced_chi_squared = degrees > 0.5 ? chi_squared / degrees : 0.0;
}

}  // namespace

bool shows(const Solution& solution, const Eigen::VectorXd& weights) {
  return solution.open.size() == 0 || (weights.transpose() * solution.open).cwiseAbs().maxCoeff() < kOpen;
}

double inflation_of(const Problem& problem, const Solution& solution) {
  const double least = problem.typical_se > 0.0 ? 1.0 : 0.0;
  return std::sqrt(std::max(least, solution.reduced_chi_squared));
}

SharedNormal shared_normal(const Problem& problem, double drift_variance) {
  std::vector<LocalMatrix> inverse;
  return eliminate_visits(problem, assemble(problem), drift_variance, inverse);
}

Solution solve(const Problem& problem) {
  const Normal normal = assemble(problem);
  const double unit = problem.typical_se > 0.0 ? problem.typical_se * problem.typical_se : 1.0;
  double drift_variance = unit;
  Solution solution = solve_with(problem, normal, drift_variance);
  for (int i = 0; i < kDriftIterations; ++i) {
    double sum = 0.0;
    for (std::size_t v = 0; v < problem.visits.size(); ++v) {
      sum += solution.local[v][kDrift] * solution.local[v][kDrift] + solution.local_variance[v][kDrift];
    }
    drift_variance = std::max(1e-6 * unit, sum / static_cast<double>(problem.visits.size()));
    solution = solve_with(problem, normal, drift_variance);
  }
  judge_residuals(problem, solution, drift_variance);
  return solution;
}

}  // namespace soak::calib::six_position
