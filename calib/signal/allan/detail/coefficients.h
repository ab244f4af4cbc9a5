// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/allan/detail/solution.h"

namespace soak::calib::signal::allan_fit {

// What a fit says of one coefficient: sqrt(theta) times `unit`, with its interval over the models of the fit and of its
// rivals. `upper`: the curve's own limits, which hold for terms that were not found and where the fit misfits.

[[nodiscard]] AllanCoefficient term_coefficient(const Fitted& fit, const UpperCurve& upper, Term term, double unit);

/// Of the Gauss-Markov process; not found: for the least restrictive correlation time.
[[nodiscard]] AllanCoefficient markov_sigma(const Fitted& fit, const UpperCurve& upper, double unit);
[[nodiscard]] AllanCoefficient markov_time(const Fitted& fit, double unit);

/// The least of the fitted curve at these averaging times, `least`, as the coefficient of flicker that alone would come
/// to it; its interval is that of the models' own curves.
[[nodiscard]] AllanCoefficient flicker_of_least(const Fitted& fit, const std::vector<double>& multiples, double least);

/// A limit from the curve itself holds whatever the fit believes; where the fit is good and has no rival, what it found
/// needs none.
void limit(AllanCoefficient& coefficient, double highest, bool doubtful);

}  // namespace soak::calib::signal::allan_fit
