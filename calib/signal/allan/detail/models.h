// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/signal/allan/detail/noise_terms.h"

namespace soak::calib::signal::allan_fit {

/// Columns of the linear problem: one per term, and the derivative of the Markov term's curve by ln T, which is in the
/// fit, with either sign, whenever the Markov term is.
constexpr Eigen::Index kMarkovTimeColumn = kTerms;
constexpr Eigen::Index kColumns = kTerms + 1;

/// a theta = y with unit covariance of y.
struct Whitened {
  Eigen::MatrixXd a;  ///< n x kColumns; a column of zeros is not available
  Eigen::VectorXd y;
};

/// A parameter must earn its place as the answer, and half as much as a possibility.
inline constexpr double kPenalty = 4.0;
inline constexpr double kBeliefPenalty = 2.0;

/// A choice of terms fitted by least squares, all their variances positive.
struct Model {
  std::vector<Eigen::Index> columns;
  Eigen::VectorXd estimate;    ///< of the columns
  Eigen::MatrixXd covariance;  ///< of the estimate
  double chi_squared = 0.0;
  double weight = 0.0;  ///< share of belief among all models, sums to 1

  [[nodiscard]] bool has(Eigen::Index column) const;
  /// 0 for a column that is not in the model.
  [[nodiscard]] double value(Eigen::Index column) const;
  [[nodiscard]] PerTerm theta() const;
};

/// The model with exactly these columns, whatever the signs.
[[nodiscard]] Model fit_columns(const Whitened& problem, const std::vector<Eigen::Index>& columns);

/// chi^2 + 4 per column: about Schwarz' criterion, ln of the number of averaging times per parameter.
[[nodiscard]] double cost(const Model& model);

/// Every choice of terms whose least-squares solution is positive, the best first: that of least cost(). The weights
/// are exp(-(chi^2 + 2 per column)/2) (Akaike's, milder than the cost: a term not needed may still be there). Models
/// below 1e-4 of the best's weight are left out. Empty if no choice is positive.
[[nodiscard]] std::vector<Model> positive_models(const Whitened& problem);

/// The model of least chi^2, however many terms it has.
[[nodiscard]] const Model& closest(const std::vector<Model>& models);

/// Mean over the models.
[[nodiscard]] PerTerm mean_theta(const std::vector<Model>& models);

}  // namespace soak::calib::signal::allan_fit
