// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/solution.h"

#include <algorithm>
#include <cmath>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr int kIterations = 6;
constexpr int kStartIterations = 10;
/// Residuals beyond so many standard deviations (robust scale) are outliers.
constexpr double kOutlier = 4.0;
/// A misfit less probable than this is taken for real.
constexpr double kSignificant = 0.01;
/// Median of chi-squared with one degree of freedom.
constexpr double kMedianSquare = 0.4549;

Eigen::VectorXd curve(const Eigen::MatrixXd& curves, const PerTerm& theta) {
  return curves.leftCols(kTerms) * Eigen::Map<const Eigen::VectorXd>(theta.data(), kTerms);
}

/// Models with independent errors, outliers bounded (Huber's weights). None where no choice of terms is positive.
std::vector<Model> starting_models(const Points& points, const PairCounts& counts, const Eigen::MatrixXd& curves) {
  const Eigen::VectorXd sigma = independent_errors(points, counts);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(sigma.size());
  std::vector<Model> models;
  for (int i = 0; i < kStartIterations; ++i) {
    const Eigen::VectorXd scale = weight.cwiseSqrt().cwiseQuotient(sigma);
    models = positive_models({scale.asDiagonal() * curves, scale.cwiseProduct(points.variance)});
    if (models.empty()) break;
    const Eigen::VectorXd residual = points.variance - curve(curves, models.front().theta());
    weight = residual.cwiseQuotient(sigma).unaryExpr([](double r) { return 1.0 / std::max(1.0, std::abs(r)); });
  }
  return models;
}

/// Of the measured variances, for the terms as they are believed now.
Eigen::MatrixXd model_covariance(const Points& points, const CovarianceTable& table, const Solution& s) {
  Eigen::MatrixXd covariance = table.covariance(s.theta);
  covariance.diagonal() += kModelError * kModelError * curve(s.curves, s.theta).cwiseAbs2();
  if (points.lag_error > 0.0) {
    const Eigen::Map<const Eigen::VectorXd> m(points.multiples.data(), covariance.rows());
    const Eigen::VectorXd error = 1.5 * points.lag_error * s.theta[white] * m.cwiseAbs2().cwiseInverse();
    covariance += error * error.transpose();
  }
  return covariance;
}

double freedom(const Solution& s, const Model& model) {
  return static_cast<double>(s.curves.rows()) - static_cast<double>(model.columns.size());
}

double misfit(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& residual) {
  return residual.dot(base::solve_ldlt(covariance, residual));
}

/// Additional variance of the averaging times that lie far off the curve, even if their own scatter is that of the
/// measured value instead of the fitted one (few degrees of freedom far above a curve are no outlier: it may have to
/// rise).
Eigen::VectorXd outlier_variance(const Eigen::VectorXd& measured, const Eigen::VectorXd& model,
                                 const Eigen::VectorXd& variance) {
  const Eigen::VectorXd square = (measured - model).cwiseAbs2();
  const Eigen::VectorXd scatter = variance.cwiseProduct(measured.cwiseQuotient(model).cwiseMax(1.0).cwiseAbs2());
  const Eigen::VectorXd ratio = square.cwiseQuotient(scatter);
  const double scale =
      std::max(1.0, base::median({ratio.data(), static_cast<std::size_t>(ratio.size())}) / kMedianSquare);
  return (square - kOutlier * kOutlier * scale * scatter).cwiseMax(0.0);
}

/// One step from the models of `s` to better ones; false if the covariance cannot be factored.
bool improve(const Points& points, const CovarianceTable& table, bool robust, Solution& s) {
  s.theta = mean_theta(s.models);
  const Eigen::MatrixXd covariance = model_covariance(points, table, s);
  s.covariance = covariance;
  if (robust) {
    const Eigen::VectorXd model = curve(s.curves, closest(s.models).theta());
    s.covariance.diagonal() += outlier_variance(points.variance, model, covariance.diagonal());
    s.covariance *= s.inflation;
  }
  const std::optional<Eigen::MatrixXd> factor = base::try_cholesky(s.covariance);
  if (!factor) return false;
  s.log_determinant = 2.0 * factor->diagonal().array().log().sum();
  s.whitened = {base::solve_lower(*factor, s.curves), base::solve_lower(*factor, points.variance)};
  s.models = positive_models(s.whitened);
  if (s.models.empty()) return false;
  s.misfit = misfit(covariance, points.variance - curve(s.curves, s.best().theta()));
  // By the closest model: a term left out must not pass for noise.
  const Model& near = closest(s.models);
  if (robust) s.inflation = std::max(1.0, s.inflation * near.chi_squared / std::max(1.0, freedom(s, near)));
  return true;
}

/// The terms if column i of the model were truly t: the others make up for it as the data demand.
PerTerm with_truth(const Solution& solution, const Model& model, Eigen::Index i, double t) {
  PerTerm theta = solution.theta;
  for (std::size_t j = 0; j < model.columns.size(); ++j) {
    const Eigen::Index k = model.columns[j];
    if (k == kMarkovTimeColumn) continue;
    const double slope = model.covariance(static_cast<Eigen::Index>(j), i) / model.covariance(i, i);
    double& value = theta[static_cast<std::size_t>(k)];
    value = std::max(0.0, value + slope * (t - model.estimate[i]));
  }
  theta[static_cast<std::size_t>(model.columns[static_cast<std::size_t>(i)])] = t;
  return theta;
}

}  // namespace

Eigen::MatrixXd term_curves(const std::vector<double>& multiples, double markov_time, double lag) {
  Eigen::MatrixXd curves = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(multiples.size()), kColumns);
  for (std::size_t i = 0; i < multiples.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const PerTerm phi = allan_variances(multiples[i], markov_time, lag);
    for (std::size_t k = 0; k < kTerms; ++k) curves(row, static_cast<Eigen::Index>(k)) = phi[k];
    if (lag != 0.0) curves(row, quantization) = 0.0;
    if (markov_time <= 0.0) continue;
    constexpr double kStep = 1e-3;
    const double above = allan_variances(multiples[i], markov_time * std::exp(kStep))[markov];
    const double below = allan_variances(multiples[i], markov_time * std::exp(-kStep))[markov];
    curves(row, kMarkovTimeColumn) = (above - below) / (2.0 * kStep);
  }
  return curves;
}

Eigen::VectorXd independent_errors(const Points& points, const PairCounts& counts) {
  Eigen::VectorXd sigma(points.variance.size());
  for (Eigen::Index i = 0; i < sigma.size(); ++i) {
    const double m = points.multiples[static_cast<std::size_t>(i)];
    sigma[i] = points.variance[i] * std::sqrt(2.0 / std::max(1.0, counts.differences(m) / m));
  }
  return sigma;
}

std::optional<Solution> solve(const Points& points, const PairCounts& counts, const CovarianceTable& table,
                              Outliers outliers, const std::optional<Model>& start) {
  Solution s;
  s.curves = term_curves(points.multiples, table.markov_time(), points.lag);
  s.models = start ? std::vector<Model>{*start} : starting_models(points, counts, s.curves);
  if (s.models.empty()) return std::nullopt;
  for (int i = 0; i < kIterations; ++i) {
    if (!improve(points, table, outliers == Outliers::down_weighted, s)) return std::nullopt;
  }
  return s;
}

double misfit_probability(const Solution& solution) {
  const double degrees = freedom(solution, solution.best());
  return degrees > 0.0 ? base::chi_squared_upper_tail(solution.misfit, degrees) : 1.0;
}

bool misfits(const Solution& solution) { return misfit_probability(solution) < kSignificant; }

VarianceEstimate variance_estimate(const Solution& solution, const CovarianceTable& table, const Model& model,
                                   Term term) {
  const auto at = std::find(model.columns.begin(), model.columns.end(), static_cast<Eigen::Index>(term));
  const Eigen::Index i = at - model.columns.begin();
  VarianceEstimate estimate{.weight = model.weight, .value = model.estimate[i]};
  // The estimate is the linear form g^T s of the measured variances s, g = V^-1 Phi C e_i.
  const Eigen::VectorXd combined = solution.curves(Eigen::all, model.columns) * model.covariance.col(i);
  const Eigen::VectorXd g = base::solve_llt(solution.covariance, combined);
  const auto variance = [&](const PerTerm& theta) { return g.dot(table.covariance(theta) * g); };
  PerTerm own{};
  own[term] = 1.0;
  const double t = std::max(estimate.value, std::sqrt(model.covariance(i, i)));
  const double constant = variance(with_truth(solution, model, i, 0.0));
  const double square = variance(own);
  const double linear = (variance(with_truth(solution, model, i, t)) - constant - square * t * t) / t;
  // What the covariance of the solution holds beside the terms: outliers, and the error of the model.
  const double rest = std::max(0.0, g.dot(solution.covariance * g) - solution.inflation * variance(solution.theta));
  // The polynomial must not fall below 0 between the two truths.
  estimate.variance = {constant, std::max(-std::sqrt(constant * square), linear), square};
  for (double& v : estimate.variance) v *= solution.inflation;
  estimate.variance[0] += rest;
  return estimate;
}

}  // namespace soak::calib::signal::allan_fit
