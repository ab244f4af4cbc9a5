// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/score.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "anfis/linear/least_squares.h"
#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kRankTolerance = 1e-9;
/// Columns of which the base leaves less than this share of their squares cannot be told from it.
constexpr double kInvisible = 1e-4;

/// Variance that the strength of an effect may have between runs, as a share of its square, without being thought
/// uneven: no two mountings are alike. Of a weak effect it is nothing beside the noise.
constexpr double kVaries = 0.3 * 0.3;

/// Pseudo-inverse of a symmetric matrix of small size, with its rank.
struct Inverse {
  Eigen::MatrixXd matrix;
  double rank = 0.0;
};

Inverse pseudo_inverse(const Eigen::MatrixXd& matrix, double scale) {
  Inverse inverse;
  inverse.matrix = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  if (matrix.size() == 0 || !(scale > 0.0)) return inverse;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    const double value = solver.eigenvalues()(k);
    if (value <= kRankTolerance * scale) continue;
    const Eigen::VectorXd v = solver.eigenvectors().col(k);
    inverse.matrix += v * v.transpose() / value;
    inverse.rank += 1.0;
  }
  return inverse;
}

Eigen::VectorXd readings(const Observations& observations, Sensor sensor) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(observations.rows.size()));
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    y(i) = observations.rows[static_cast<std::size_t>(i)].sensor[index_of(sensor)].mean;
  }
  return y;
}

}  // namespace

SensorResidual::SensorResidual(const Observations& observations, Sensor sensor, const Eigen::MatrixXd& base,
                               const NoiseComponents& noise, const std::vector<bool>& keep,
                               const Eigen::VectorXd& prior)
    : whitening_(observations, sensor, noise, keep) {
  const Eigen::Index rows = static_cast<Eigen::Index>(whitening_.rows().size());
  if (rows == 0) return;
  // A prior about 0 is one more reading of 0 for each column.
  Eigen::MatrixXd white = Eigen::MatrixXd::Zero(rows + base.cols(), base.cols());
  white.topRows(rows) = whitening_.apply(base);
  white.bottomRows(base.cols()) = prior.asDiagonal();
  Eigen::VectorXd y = Eigen::VectorXd::Zero(white.rows());
  y.head(rows) = whitening_.apply(readings(observations, sensor));
  const anfis::LeastSquaresFit fit = anfis::solve_least_squares(white, y, kRankTolerance);
  coefficients_ = fit.coefficients;
  coefficient_factor_ = fit.covariance_factor;
  // X F has orthonormal columns, as F Fᵀ is the pseudo-inverse of XᵀX. Nothing else has a part in the prior's rows.
  basis_ = white.topRows(rows) * coefficient_factor_;
  residual_ = y.head(rows) - basis_ * (basis_.transpose() * y.head(rows));
}

Eigen::MatrixXd SensorResidual::project(Eigen::MatrixXd white) const {
  white -= basis_ * (basis_.transpose() * white);
  return white;
}

void TermScore::add(const TermScore& other) {
  if (score.empty()) {
    *this = other;
    return;
  }
  for (std::size_t f = 0; f < score.size(); ++f) {
    score[f] += other.score[f];
    information[f] += other.information[f];
  }
  total_score += other.total_score;
  total_information += other.total_information;
  visible_share = std::max(visible_share, other.visible_share);
}

TermScore score_term(const SensorResidual& sensor, const Eigen::MatrixXd& columns, const std::vector<int>& folds,
                     int fold_count) {
  const Eigen::Index p = columns.cols();
  TermScore result;
  result.score.assign(static_cast<std::size_t>(fold_count), Eigen::VectorXd::Zero(p));
  result.information.assign(static_cast<std::size_t>(fold_count), Eigen::MatrixXd::Zero(p, p));
  Eigen::MatrixXd white = sensor.whiten(columns);
  const double before = white.squaredNorm();
  white = sensor.project(std::move(white));
  const auto& rows = sensor.rows();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto f = static_cast<std::size_t>(folds[static_cast<std::size_t>(rows[k])]);
    const auto row = white.row(static_cast<Eigen::Index>(k));
    result.score[f] += row.transpose() * sensor.residual()(static_cast<Eigen::Index>(k));
    result.information[f] += row.transpose() * row;
  }
  result.total_score = Eigen::VectorXd::Zero(p);
  result.total_information = Eigen::MatrixXd::Zero(p, p);
  for (std::size_t f = 0; f < result.score.size(); ++f) {
    result.total_score += result.score[f];
    result.total_information += result.information[f];
  }
  result.visible_share = before > 0.0 ? white.squaredNorm() / before : 0.0;
  return result;
}

TermTest test_term(const TermScore& score) {
  TermTest test;
  const auto scale = score.total_information.diagonal().maxCoeff();
  const Inverse inverse = pseudo_inverse(score.total_information, scale);
  test.dof = score.visible_share > kInvisible ? inverse.rank : 0.0;
  test.parameters = inverse.matrix * score.total_score;
  test.covariance = inverse.matrix;
  if (test.dof <= 0.0) return test;
  test.gain = score.total_score.dot(test.parameters);

  double scatter = 0.0;
  double ranks = 0.0;
  for (std::size_t f = 0; f < score.score.size(); ++f) {
    const Inverse own = pseudo_inverse(score.information[f], scale);
    if (own.rank <= 0.0) {
      test.fold_gain.emplace_back();
      continue;
    }
    const Eigen::VectorXd off = score.score[f] - score.information[f] * test.parameters;
    // Strength is drawn per run: its variance c theta theta' adds to that of the noise (Sherman-Morrison).
    const double along = off.dot(test.parameters);
    const double strength = test.parameters.dot(score.information[f] * test.parameters);
    scatter += off.dot(own.matrix * off) - kVaries * along * along / (1.0 + kVaries * strength);
    ranks += own.rank;
    const Inverse others = pseudo_inverse(score.total_information - score.information[f], scale);
    const Eigen::VectorXd elsewhere = others.matrix * (score.total_score - score.score[f]);
    test.fold_gain.emplace_back(2.0 * elsewhere.dot(score.score[f]) - elsewhere.dot(score.information[f] * elsewhere));
  }
  test.heterogeneity_dof = std::max(0.0, ranks - test.dof);
  test.heterogeneity = test.heterogeneity_dof > 0.0 ? scatter / test.heterogeneity_dof : 1.0;
  return test;
}

int TermTest::judged_folds() const {
  return static_cast<int>(
      std::count_if(fold_gain.begin(), fold_gain.end(), [](const auto& g) { return g.has_value(); }));
}

int TermTest::supporting_folds() const {
  return static_cast<int>(
      std::count_if(fold_gain.begin(), fold_gain.end(), [](const auto& g) { return g && *g > 0.0; }));
}

double TermTest::gain_beside_best_fold() const {
  double sum = 0.0;
  double best = 0.0;
  for (const auto& gain : fold_gain) {
    sum += gain.value_or(0.0);
    best = std::max(best, gain.value_or(0.0));
  }
  return sum - best;
}

TermTest pooled(std::span<const TermTest* const> tests) {
  TermTest sum;
  double scatter = 0.0;
  for (const TermTest* test : tests) {
    sum.gain += test->gain;
    sum.dof += test->dof;
    sum.heterogeneity_dof += test->heterogeneity_dof;
    sum.noise_dof += test->noise_dof;
    scatter += test->heterogeneity * test->heterogeneity_dof;
    sum.fold_gain.resize(std::max(sum.fold_gain.size(), test->fold_gain.size()));
    for (std::size_t f = 0; f < test->fold_gain.size(); ++f) {
      if (test->fold_gain[f]) sum.fold_gain[f] = sum.fold_gain[f].value_or(0.0) + *test->fold_gain[f];
    }
  }
  if (sum.heterogeneity_dof > 0.0) sum.heterogeneity = scatter / sum.heterogeneity_dof;
  return sum;
}

double moderated_heterogeneity(const TermTest& test, double typical) {
  const double drawn =
      (kPriorDof * typical + test.heterogeneity_dof * test.heterogeneity) / (kPriorDof + test.heterogeneity_dof);
  return std::max(1.0, drawn);
}

double scatter_dof(const NoiseComponents& noise) {
  constexpr double kMost = 24.0;
  return std::min(kMost, noise.visit_dof);
}

double p_value(const TermTest& test, double typical) {
  if (test.dof <= 0.0 || test.gain <= 0.0) return 1.0;
  const double f = test.gain / test.dof / moderated_heterogeneity(test, typical);
  return base::f_upper_tail(f, test.dof, test.noise_dof + test.heterogeneity_dof);
}

}  // namespace soak::calib::gap
