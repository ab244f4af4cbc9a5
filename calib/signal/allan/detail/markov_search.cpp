// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/markov_search.h"

#include <algorithm>
#include <cmath>

#include "base/linear/dense_solve.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr double kEvidence = 16.0;
/// Correlation times from 1 interval; neighbours on the grid make curves that differ by less than 10 %.
constexpr double kGridRatio = 1.5;
constexpr int kRefinements = 8;
constexpr int kTables = 2;
/// Largest step in ln T.
constexpr double kLongestStep = 0.5;

/// The best model with a Markov term of this time under a given covariance of the data.
std::optional<Model> model_at(const Points& points, const Eigen::MatrixXd& factor, double time) {
  const Eigen::MatrixXd curves = term_curves(points.multiples, time);
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
  for (double time = 1.0; time < 0.5 * points.multiples.back(); time *= kGridRatio) {
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
    fitted = Fitted{std::move(table), std::move(*solution)};
  }
  return fitted;
}

}  // namespace soak::calib::signal::allan_fit
