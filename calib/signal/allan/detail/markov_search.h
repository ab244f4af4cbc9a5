// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/signal/allan/detail/solution.h"

namespace soak::calib::signal::allan_fit {

/// The fit with a first-order Gauss-Markov term, if the measured curve demands one: its correlation time by least chi^2
/// over a logarithmic grid from points.shortest_markov_time on, refined by Gauss-Newton steps together with all other
/// coefficients. Nothing if its two parameters improve chi^2 by less than 16 beyond the penalty for parameters (the
/// time was searched for, and flicker between white noise and random walk looks much the same).
[[nodiscard]] std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts,
                                                    const Solution& without, Outliers outliers);

/// The same without asking whether the curve demands it, and without another fit's covariance: the time is searched for
/// with independent errors. Where flicker stands for a Gauss-Markov process, the covariance of that flicker makes the
/// longest averaging times, which tell the two apart, look as if they knew nothing.
[[nodiscard]] std::optional<Fitted> fit_with_markov(const Points& points, const PairCounts& counts, Outliers outliers);

/// What fit is to be believed where both describe the curve, `without` and `with` a Gauss-Markov term. Each is judged
/// under its own covariance: -2 ln likelihood = chi^2 + ln det V. With one that is better by 16 beyond the penalty for
/// parameters, `with` is the answer. Else `without` is, and `with` its rival, its share of belief by the same
/// likelihood.
[[nodiscard]] Fitted preferred(Fitted without, Fitted with);

}  // namespace soak::calib::signal::allan_fit
