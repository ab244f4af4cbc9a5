// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "base/result.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/curve_data.h"

namespace soak::calib {

/// Whether the rows are of one temperature, within 10 K: less than three temperatures that are half a kelvin apart, or
/// sessions of one each, whose differences nobody can tell from the offsets of the power-ons.
[[nodiscard]] bool is_of_one_temperature(const CurveData& data);

/// The constant of rows of one temperature: mean over the runs of each run's weighted mean.
///
/// Uncertainty, as in fit_curve(): `noise`, from the rows' standard errors (a row's degrees of freedom are Student's);
/// `run_to_run`, from the scatter of R ≥ 2 runs beyond that, σ² = max(0, s² − mean u²), σ²/R in the band of the
/// mean, with R − 1 degrees of freedom (of two or three runs σ² = s², and `noise` is what u²/R exceeds s²/R by); with
/// one run it is not stated, and there is no pi95; `temperature`, what the unit's type says of the change per kelvin
/// (limits ±c·|T − T0|, rectangular) at temperatures T that the constant was not measured at; then the type B inputs.
/// The valid range is that of the sessions, and `within_c` beyond on both sides.
///
/// Refuses rows that are not finite.
[[nodiscard]] base::Result<CurveFit> fit_constant(const CurveData& data, const CurveSubject& subject,
                                                  const ConstantValidity& validity,
                                                  const std::optional<double>& change_per_k,
                                                  std::span<const TypeBInput> type_b = {});

}  // namespace soak::calib
