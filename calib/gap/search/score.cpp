// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kLeastEigenvalue = 1e-9;  ///< of the largest information
/// Columns of which the base leaves less than this share of their squares cannot be told from it.
constexpr double kInvisibleShare = 1e-4;

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
  const base::SymmetricEigen eigen = base::symmetric_eigen(matrix);
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    const double value = eigen.values(k);
    if (value <= kLeastEigenvalue * scale) continue;
    const Eigen::VectorXd v = eigen.vectors.col(k);
    inverse.matrix += v * v.transpose() / value;
    inverse.rank += 1.0;
  }
  return inverse;
}

/// Score and information of a term's parameters, fold by fold: all that a test of it needs.
struct TermScore {
  std::vector<Eigen::VectorXd> score;        ///< Dᵀe of each fold
  std::vector<Eigen::MatrixXd> information;  ///< DᵀD of each fold
  Eigen::VectorXd total_score;
  Eigen::MatrixXd total_information;
  /// Share of the whitened columns' squares that the base leaves: 0 = the base absorbs the term.
  double visible_share = 0.0;

  /// Adds that of another sensor with the same parameters.
  void add(const TermScore& other) {
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
};

/// `folds`: fold number of each observation, `fold_count` of them.
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
  const auto fold_of = [&](std::size_t k) {
    return static_cast<std::size_t>(folds[static_cast<std::size_t>(rows[k])]);
  };
  for (std::size_t first = 0, last = 0; first < rows.size(); first = last) {
    while (last < rows.size() && fold_of(last) == fold_of(first)) ++last;
    const auto begin = static_cast<Eigen::Index>(first);
    const auto count = static_cast<Eigen::Index>(last - first);
    const auto part = white.middleRows(begin, count);
    result.score[fold_of(first)].noalias() += part.transpose() * sensor.residual().segment(begin, count);
    result.information[fold_of(first)].noalias() += part.transpose() * part;
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
  test.dof = score.visible_share > kInvisibleShare ? inverse.rank : 0.0;
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

bool enough_folds(const TermTest& test) {
  int judged = 0;
  int supporting = 0;
  double sum = 0.0;
  double best = 0.0;
  for (const auto& gain : test.fold_gain) {
    if (!gain) continue;
    ++judged;
    if (*gain > 0.0) ++supporting;
    sum += *gain;
    best = std::max(best, *gain);
  }
  return judged >= 2 && 2 * supporting >= judged && sum - best > 0.0;
}

/// Sensors that show a term, each tested alone.
std::vector<Sensor> sensors_that_show(const CandidateTest& test) {
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    if (test.sensor[index_of(sensor)] && test.sensor[index_of(sensor)]->dof > 0.0) sensors.push_back(sensor);
  }
  return sensors;
}

}  // namespace

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

double term_dof(const NoiseComponents& noise, double slow_share, int runs) {
  if (slow_share <= 0.0) return scatter_dof(noise);
  const double quick_share = 1.0 - slow_share;
  const double of_slow = std::max(1.0, static_cast<double>(runs) - 1.0);
  return 1.0 / (quick_share * quick_share / std::max(1.0, scatter_dof(noise)) + slow_share * slow_share / of_slow);
}

double p_value(const TermTest& test, double typical) {
  if (test.dof <= 0.0 || test.gain <= 0.0) return 1.0;
  const double f = test.gain / test.dof / moderated_heterogeneity(test, typical);
  const double of_folds = (1.0 - test.slow_share) * test.heterogeneity_dof;
  return base::f_upper_tail(f, test.dof, test.noise_dof + of_folds);
}

double p_value(std::span<const TermTest* const> tests, double typical) {
  const auto is_slow = [](const TermTest* test) { return test->slow_share > 0.0; };
  if (std::ranges::none_of(tests, is_slow)) return p_value(pooled(tests), typical);
  std::vector<double> chances;
  for (const TermTest* test : tests) chances.push_back(p_value(*test, typical));
  return chance_together(chances);
}

std::vector<std::vector<Sensor>> sensor_sets(const std::vector<Sensor>& sensors) {
  std::vector<std::vector<Sensor>> sets(3);
  for (const Sensor sensor : sensors) {
    sets[0].push_back(sensor);
    sets[is_gyro(sensor) ? 1 : 2].push_back(sensor);
    sets.push_back({sensor});
  }
  std::sort(sets.begin(), sets.end());
  sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  return sets;
}

double chance_together(std::span<const double> chances) {
  if (chances.empty()) return 1.0;
  double squares = 0.0;
  for (const double p : chances) squares -= 2.0 * std::log(std::max(p, std::numeric_limits<double>::min()));
  return base::chi_squared_upper_tail(squares, 2.0 * static_cast<double>(chances.size()));
}

CandidateTest test_candidate(const Residuals& residuals, const Candidate& candidate) {
  const bool by_run = candidate.folds == Folds::runs;
  CandidateTest result;
  TermScore together;
  double noise_dof = 0.0;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!residuals.sensor[s] || candidate.columns[s].size() == 0) continue;
    const TermScore score =
        score_term(*residuals.sensor[s], candidate.columns[s], by_run ? residuals.run_fold : residuals.level_fold,
                   by_run ? residuals.runs : residuals.levels);
    result.sensor[s] = test_term(score);
    const double slow_share = residuals.sensor[s]->slow_share(candidate.columns[s]);
    result.sensor[s]->slow_share = slow_share;
    result.sensor[s]->noise_dof = term_dof(residuals.noise[s], slow_share, residuals.runs);
    noise_dof += result.sensor[s]->noise_dof;
    if (candidate.shared) together.add(score);
  }
  if (candidate.shared && !together.score.empty()) {
    result.shared = test_term(together);
    result.shared->noise_dof = noise_dof;
  }
  return result;
}

Standing standing(const CandidateTest& test, const Candidate& candidate, double typical, double price) {
  constexpr double kSensorGate = 0.01;  // chance from which a sensor by itself counts as hit, beside a named effect
  const auto worth = [&](const TermTest& of) { return of.gain / moderated_heterogeneity(of, typical); };
  const auto shape_numbers = static_cast<double>(candidate.shape_values.size());
  Standing result;
  if (candidate.shared) {
    if (!test.shared || test.shared->dof <= 0.0) return result;
    result.p = p_value(*test.shared, typical);
    result.enough_folds = enough_folds(*test.shared);
    result.gain = worth(*test.shared);
    result.merit = result.gain - price * (test.shared->dof + shape_numbers);
    result.sensors = sensors_that_show(test);
    return result;
  }
  // The set of sensors with the least chance.
  const std::vector<Sensor> sensors = sensors_that_show(test);
  const auto sets = sensor_sets(sensors);
  bool first = true;
  for (const auto& set : sets) {
    std::vector<const TermTest*> tests;
    for (const Sensor sensor : set) tests.push_back(&*test.sensor[index_of(sensor)]);
    const double p = std::min(1.0, p_value(tests, typical) * static_cast<double>(sets.size()));
    if (p >= result.p && !first) continue;
    first = false;
    result.p = p;
    result.enough_folds = enough_folds(pooled(tests));
  }
  result.merit = -price * shape_numbers;
  for (const Sensor sensor : sensors) {
    const TermTest& own = *test.sensor[index_of(sensor)];
    const double gain = worth(own);
    if (gain <= price * own.dof || p_value(own, typical) > kSensorGate) continue;
    result.sensors.push_back(sensor);
    result.gain += gain;
    result.merit += gain - price * own.dof;
  }
  return result;
}

}  // namespace soak::calib::gap
