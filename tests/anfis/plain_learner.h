// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/train/learner.h"

namespace soak::anfis::test {

/// What a PlainLearner saw in one epoch.
struct PlainEpoch {
  double rmse;  ///< units of y: sqrt(r^T V^-1 r / sum of weights)
  double step;  ///< length of the premise step made after it
};

/// A second implementation of hybrid learning, for comparison: extended precision, plain loops over rows and rules, the
/// dense inverse of V, normal equations by Gauss-Jordan elimination, central differences for derivatives. It knows
/// every shape, both T-norms, both orders, kAny, shared memberships, dropped gains, weights and groups of finite
/// variance; it has no bounds. Some rule must fire at every row, and no row may lie within 1e-6 of a kink.
class PlainLearner {
 public:
  /// Of the options: epochs, initial_step, step_decrease, step_increase.
  PlainLearner(const Model& initial, const TrainingData& data, const HybridOptions& options);

  std::vector<PlainEpoch> learn();

 private:
  using Real = long double;
  using Matrix = std::vector<std::vector<Real>>;
  using Parameters = std::array<Real, 4>;

  static Matrix solve(Matrix a, Matrix b);
  static Real degree(Shape shape, const Parameters& p, Real u);
  static Matrix inverse_covariance(const TrainingData& data);

  [[nodiscard]] Real strength(const Rule& rule, const std::vector<Real>& u) const;
  [[nodiscard]] std::vector<Real> regressors(const std::vector<Real>& u) const;
  [[nodiscard]] Real error() const;
  void solve_consequents();
  void move(double step);
  [[nodiscard]] double next_step(const std::vector<PlainEpoch>& history, double step);

  HybridOptions options_;
  Model model_;  ///< structure and scales
  Matrix u_;     ///< scaled inputs of each row
  Matrix y_;     ///< scaled output of each row
  Matrix inverse_;
  Real total_weight_ = 0;
  std::vector<std::vector<Parameters>> premises_;  ///< of each input
  Matrix consequents_;
  std::size_t last_increase_ = 0, last_decrease_ = 0;
};

}  // namespace soak::anfis::test
