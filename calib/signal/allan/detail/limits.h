// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "calib/signal/allan/detail/covariance.h"

namespace soak::calib::signal::allan_fit {

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
};

/// No term can have more variance than there is: min over m of upper(m)/phi(m), the largest theta that keeps the
/// term's own curve below the limits.
[[nodiscard]] double largest_theta(const UpperCurve& upper, Term term, double markov_time);

/// The same for a Gauss-Markov term whose time is not known: the largest over the times between the first and the last
/// multiple.
[[nodiscard]] double largest_markov_theta(const UpperCurve& upper);

}  // namespace soak::calib::signal::allan_fit
