// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/markov_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/linear/dense_solve.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr double kEvidence = 16.0;
/// Neighbours on the grid make curves that differ by less than 10 %.
constexpr double kGridRatio = 1.5;
constexpr int kRefinements = 8;
constexpr int kTables = 2;
/// Largest step in ln T.
constexpr double kLongestStep = 0.5;

/// The best model with a Markov term of this time under a given covariance of the data, factor factor^T.
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

std::optional<Found> best_on_grid(const Points& points, const Eigen::MatrixXd& factor, double shortest) {
  std::optional<Found> best;
  for (double time = shortest; time < 0.5 * points.multiples.back(); time *= kGridRatio) {
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

/// Terms, covariance for them, and the time under that covariance, in turn.
std::optional<Fitted> converged(const Points& points, const PairCounts& counts, Outliers outliers, Found found) {
  std::optional<Fitted> fitted;
  for (int i = 0; i < kTables; ++i) {
    CovarianceTable table(counts, points.multiples, found.time);
    found.model.weight = 1.0;
    std::optional<Solution> solution = solve(points, counts, table, outliers, found.model);
    if (!solution || !solution->best().has(markov)) return std::nullopt;
    found.model = solution->best();
    if (i + 1 < kTables) found.time = refined_time(points, base::cholesky(solution->covariance), found);
    fitted = Fitted{.table = std::move(table), .solution = std::move(*solution), .lag = points.lag};
  }
  return fitted;
}

/// -2 ln likelihood, and so much for each parameter.
double deviance(const Solution& solution, double penalty) {
  const Model& best = solution.best();
  return best.chi_squared + solution.log_determinant + penalty * static_cast<double>(best.columns.size());
}

}  // namespace

std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts, const Solution& without,
                                      Outliers outliers) {
  const Eigen::MatrixXd factor = base::cholesky(without.covariance);
  std::optional<Found> found = best_on_grid(points, factor, points.shortest_markov_time);
  if (!found || cost(found->model) > cost(without.best()) - kEvidence) return std::nullopt;
  found->time = refined_time(points, factor, *found);
  return converged(points, counts, outliers, std::move(*found));
}

std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts, Outliers outliers) {
  const Eigen::MatrixXd factor = independent_errors(points, counts).asDiagonal();
  // A process that is over within the first averaging time is white at all of them.
  const double shortest = std::max(points.shortest_markov_time, points.multiples.front());
  std::optional<Found> found = best_on_grid(points, factor, shortest);
  if (!found) return std::nullopt;
  return converged(points, counts, outliers, std::move(*found));
}

Fitted preferred(Fitted without, Fitted with) {
  const double gain = deviance(without.solution, kPenalty) - deviance(with.solution, kPenalty);
  if (gain > kEvidence) return with;
  const double belief = deviance(without.solution, kBeliefPenalty) - deviance(with.solution, kBeliefPenalty);
  with.share = 1.0 / (1.0 + std::exp(-0.5 * belief));
  without.share = 1.0 - with.share;
  without.rivals.push_back(std::move(with));
  return without;
}

}  // namespace soak::calib::signal::allan_fit
