// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/signal/allan/detail/solution.h"

namespace soak::calib::signal::allan_fit {

/// A solution and the table of covariances that it was made with.
struct Fitted {
  CovarianceTable table;
  Solution solution;
};

/// The fit with a first-order Gauss-Markov term, if the measured curve demands one: its correlation time by least chi^2
/// over a logarithmic grid, refined by Gauss-Newton steps together with all other coefficients. Nothing if its two
/// parameters improve chi^2 by less than 16 beyond the penalty for parameters (the time was searched for, and flicker
/// between white noise and random walk looks much the same).
[[nodiscard]] std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts,
                                                    const Solution& without, Outliers outliers);

}  // namespace soak::calib::signal::allan_fit
