// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/signal/allan/detail/intervals.h"
#include "calib/signal/allan/detail/models.h"

namespace soak::calib::signal::allan_fit {

/// The averaging times that the fit uses.
struct Points {
  std::vector<double> multiples;
  Eigen::VectorXd variance;  ///< measured
  double lag = 0.0;          ///< of the low-pass whose memory all of them lie beyond
  double lag_error = 0.0;    ///< standard deviation
  double shortest_markov_time = 1.0;
};

/// Every term's curve at the multiples, n x kColumns (see models.h). With a lag quantization is not available: both
/// bend the curve at the shortest times, and nothing tells them apart.
[[nodiscard]] Eigen::MatrixXd term_curves(const std::vector<double>& multiples, double markov_time, double lag);

/// The curves hold to this share of the Allan variance at best: sampled sensors are no textbook integrals.
constexpr double kModelError = 1e-3;

/// What fitting came to.
struct Solution {
  Eigen::MatrixXd curves;      ///< term_curves() at the points
  Eigen::MatrixXd covariance;  ///< of the measured variances under the fitted terms, outliers and inflation included
  PerTerm theta{};             ///< that this covariance is for: mean over the models
  Whitened whitened;
  std::vector<Model> models;     ///< the best first
  double misfit = 0.0;           ///< chi^2 of the best model when no averaging time counts less
  double inflation = 1.0;        ///< factor on that covariance: chi^2 per degree of freedom, at least 1
  double log_determinant = 0.0;  ///< of `covariance`

  [[nodiscard]] const Model& best() const { return models.front(); }
};

/// How the iteration treats averaging times that lie far off the curve.
enum class Outliers {
  kept,          ///< like all others
  down_weighted  ///< additional variance in the size of their residual, and all variances inflated by chi^2 per degree
                 ///< of freedom
};

/// Iterated generalised least squares: terms -> covariance of the measured variances -> terms. `start`: begin with this
/// model instead of a fit with independent errors. Nothing if a covariance cannot be factored.
[[nodiscard]] std::optional<Solution> solve(const Points& points, const PairCounts& counts,
                                            const CovarianceTable& table, Outliers outliers,
                                            const std::optional<Model>& start = {});

/// Of a misfit at least as large as that of the best model.
[[nodiscard]] double misfit_probability(const Solution& solution);

/// A fit less probable than 1 % does not know what the noise is.
[[nodiscard]] bool misfits(const Solution& solution);

/// The estimate of a term's variance in one model, with the variance that it would have at other true values.
[[nodiscard]] VarianceEstimate variance_estimate(const Solution& solution, const CovarianceTable& table,
                                                 const Model& model, Term term);

/// Standard deviations of the measured variances if they were independent: s sqrt(2/edf), edf about n/m.
[[nodiscard]] Eigen::VectorXd independent_errors(const Points& points, const PairCounts& counts);

/// A solution and the table of covariances that it was made with.
struct Fitted {
  CovarianceTable table;
  Solution solution;
  double lag = 0.0;                 ///< of the points
  double share = 1.0;               ///< of belief, beside the rivals
  std::vector<Fitted> rivals = {};  ///< fits nearly as good, of another correlation time; without rivals of their own
};

}  // namespace soak::calib::signal::allan_fit
