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

/// Models with independent errors of s sqrt(2/edf), edf about n/m, outliers bounded (Huber's weights). None where no
/// choice of terms is positive.
std::vector<Model> starting_models(const Points& points, const PairCounts& counts, const Eigen::MatrixXd& curves) {
  Eigen::VectorXd sigma(points.variance.size());
  for (Eigen::Index i = 0; i < sigma.size(); ++i) {
    const double m = points.multiples[static_cast<std::size_t>(i)];
    sigma[i] = points.variance[i] * std::sqrt(2.0 / std::max(1.0, counts.differences(m) / m));
  }
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

constexpr double kEvidence = 16.0;
/// Neighbours on the grid make curves that differ by less than 10 %.
constexpr double kGridRatio = 1.5;
constexpr int kRefinements = 8;
constexpr int kTables = 2;
/// Largest step in ln T.
constexpr double kLongestStep = 0.5;

/// The best model with a Markov term of this time under a given covariance of the data.
std::optional<Model> model_at(const Points& points, const Eigen::MatrixXd& factor, double time) {
  const Eigen::MatrixXd curves = term_curves(points.multiples, time, points.lag);
  const Whitened whitened{base::solve_lower(factor, curves), base::solve_lower(factor, points.variance)};
  for (Model& model : positive_models(whitened)) {
    if (model.has(markov)) return std::move(model);
  }
  return std::nullopt;
}

struct Found {
  double time = 0.0;
  Model model;
};

std::optional<Found> best_on_grid(const Points& points, const Eigen::MatrixXd& factor) {
  std::optional<Found> best;
  for (double time = points.shortest_markov_time; time < 0.5 * points.multiples.back(); time *= kGridRatio) {
    std::optional<Model> model = model_at(points, factor, time);
    if (model && (!best || cost(*model) < cost(best->model))) best = Found{time, std::move(*model)};
  }
  return best;
}

/// sigma^2 (phi + delta dphi/dlnT): the ratio of the two coefficients is the step in ln T.
double refined_time(const Points& points, const Eigen::MatrixXd& factor, Found found) {
  for (int i = 0; i < kRefinements; ++i) {
    const double step = found.model.value(kMarkovTimeColumn) / found.model.value(markov);
    const double time = found.time * std::exp(std::clamp(step, -kLongestStep, kLongestStep));
    std::optional<Model> model = model_at(points, factor, time);
    if (!model || cost(*model) > cost(found.model) + kEvidence) break;
    found = Found{time, std::move(*model)};
    if (std::abs(step) < 1e-4) break;
  }
  return found.time;
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

bool misfits(const Solution& solution) {
  const Model& near = closest(solution.models);
  const double degrees = freedom(solution, near);
  return degrees >= 1.0 && base::chi_squared_upper_tail(near.chi_squared, degrees) < kSignificant;
}

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

std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts, const Solution& without,
                                      Outliers outliers) {
  std::optional<Found> found = best_on_grid(points, base::cholesky(without.covariance));
  if (!found || cost(found->model) > cost(without.best()) - kEvidence) return std::nullopt;
  double time = refined_time(points, base::cholesky(without.covariance), *found);
  std::optional<Fitted> fitted;
  for (int i = 0; i < kTables; ++i) {
    CovarianceTable table(counts, points.multiples, time);
    found->model.weight = 1.0;
    std::optional<Solution> solution = solve(points, counts, table, outliers, found->model);
    if (!solution || !solution->best().has(markov)) return std::nullopt;
    found = Found{time, solution->best()};
    if (i + 1 < kTables) time = refined_time(points, base::cholesky(solution->covariance), *found);
    fitted = Fitted{std::move(table), std::move(*solution), points.lag};
  }
  return fitted;
}

}  // namespace soak::calib::signal::allan_fit
