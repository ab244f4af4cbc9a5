// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/detail/interval_likelihood.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace soak::calib::gap {
namespace {

constexpr double kFar = 30.0;  ///< sigmas from which erfc() leaves the range of numbers

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi); }

/// Beyond kFar the nearer end decides: P = φ(l)/l (1 − 1/l² …).
IntervalLikelihood of_far(double l) {
  return {-0.5 * l * l - std::log(l * std::sqrt(2.0 * std::numbers::pi)), l + 1.0 / l, 1.0};
}

/// Ends in sigmas, the middle of the interval not below the mean: P = Φ(u) − Φ(l) without cancellation.
IntervalLikelihood of_upper(double l, double u) {
  if (l > kFar) return of_far(l);
  const double chance = 0.5 * (std::erfc(l / std::numbers::sqrt2) - std::erfc(u / std::numbers::sqrt2));
  const double at_l = density(l) / chance;
  const double at_u = density(u) / chance;
  const double score = at_l - at_u;
  return {std::log(chance), score, std::max(0.0, score * score - (l * at_l - u * at_u))};
}

}  // namespace

IntervalLikelihood interval_likelihood(double low, double high, double sigma) {
  const bool above = low + high >= 0.0;
  IntervalLikelihood likelihood = above ? of_upper(low / sigma, high / sigma) : of_upper(-high / sigma, -low / sigma);
  likelihood.score *= (above ? 1.0 : -1.0) / sigma;
  likelihood.curvature /= sigma * sigma;
  return likelihood;
}

}  // namespace soak::calib::gap
