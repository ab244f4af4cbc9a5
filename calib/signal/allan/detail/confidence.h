// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

namespace soak::calib::signal::allan_fit {

/// An estimate of a variance t >= 0 by a quadratic form of Gaussian data. Its own variance depends on the truth,
///   v(t) = variance[0] + variance[1] t + variance[2] t^2,
/// the last part chi-squared with 2/variance[2] degrees of freedom, the rest taken as normal.
struct VarianceEstimate {
  double weight = 1.0;  ///< share of belief in the model that it is from
  double value = 0.0;
  std::array<double, 3> variance{};
};

/// What the data say about a variance when several models are possible: the mean, over the models, of
///   P(truth <= t) = P(an estimate at least as large as `value`, if the truth were t),
/// with the distribution of the estimate about t by its first three moments (Pearson type III, Wilson and Hilferty's
/// transformation). Weight missing to 1 stands for models without the term: truth 0.
class ConfidenceDistribution {
 public:
  explicit ConfidenceDistribution(std::vector<VarianceEstimate> estimates) : estimates_(std::move(estimates)) {}

  /// P(truth <= t), rising from t = 0.
  [[nodiscard]] double probability(double t) const;
  /// t with probability(t) = p in (0, 1); 0 where even 0 has more.
  [[nodiscard]] double quantile(double p) const;

 private:
  std::vector<VarianceEstimate> estimates_;
};

}  // namespace soak::calib::signal::allan_fit
