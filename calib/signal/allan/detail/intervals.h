// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "calib/signal/allan/detail/noise_terms.h"

namespace soak::calib::signal::allan_fit {

/// Of an interval of 95 %.
inline constexpr std::array<double, 2> kTails = {0.025, 0.975};

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

/// Relative variance, 2/edf, of the Allan variance at one averaging time m for the terms theta. `pairs`:
/// covariance_terms() at (m, m).
[[nodiscard]] double relative_variance(const TermPairs& pairs, const PerTerm& theta, double allan_variance);

/// The largest that white noise, flicker noise or a random walk alone has: what can be said of a measured variance
/// whose noise is not understood.
[[nodiscard]] double power_law_relative_variance(const TermPairs& pairs, double m);

/// Upper limits of the Allan variance at the multiples.
struct UpperCurve {
  std::span<const double> multiples;
  std::span<const double> variance;
  double lag = 0.0;  ///< of a low-pass, see allan_variances()
};

/// No term can have more variance than there is: min over m of upper(m)/phi(m), the largest theta that keeps the
/// term's own curve below the limits.
[[nodiscard]] double largest_theta(const UpperCurve& upper, Term term, double markov_time);

/// The same for a Gauss-Markov term whose time is not known: the largest over the times between the first and the last
/// multiple.
[[nodiscard]] double largest_markov_theta(const UpperCurve& upper);

}  // namespace soak::calib::signal::allan_fit
