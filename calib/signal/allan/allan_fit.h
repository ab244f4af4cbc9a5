// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/signal/allan/allan.h"
#include "calib/signal/spectrum/low_pass.h"

namespace soak::calib::signal {

/// An overlapping Allan deviation curve and what it was computed from.
struct AllanCurve {
  double interval_s = 1.0;
  std::vector<std::size_t> stretches;  ///< phase points of each stretch without a gap
  std::vector<std::size_t> multiples;  ///< averaging times in intervals, rising
  std::vector<double> deviation;       ///< overlapping Allan deviation at each
  std::optional<LowPass>
      low_pass;  ///< of the unit, from find_low_pass(): without it what a filter does passes for noise
};

/// The overlapping deviations of a record at these averaging times; without a low-pass.
[[nodiscard]] AllanCurve overlapping_curve(const PhaseRecord& record, std::span<const std::size_t> multiples);

/// A coefficient with its two-sided 95 % interval (never below 0; the upper end of N at 98.5 instead of 97.5 %).
/// `found` false: the curve shows no trace of the term; `value` is then 0 (but see AllanFit::bias_instability) and
/// `high` what could have stayed hidden. Where a term was not found or the fit misfits, `high` is no more than lets the
/// term's own curve stay below the upper ends of AllanFit::ci95.
struct AllanCoefficient {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
  bool found = false;
};

/// Noise terms of IEEE 952, Allan variance as the sum of
///   3 Q^2/tau^2  +  N^2/tau  +  (2 ln2/pi) B^2  +  K^2 tau/3  +  R^2 tau^2/2  +  Markov(q_c, T_c).
/// U is the unit of the rate.
struct AllanFit {
  AllanCoefficient quantization;       ///< Q in U*s
  AllanCoefficient angle_random_walk;  ///< N in U*sqrt(s)
  AllanCoefficient flicker;            ///< B of the flat term in U
  AllanCoefficient rate_random_walk;   ///< K in U/sqrt(s)
  AllanCoefficient rate_ramp;          ///< R in U/s
  /// Standard deviation of the first-order Gauss-Markov term in U. Not found: `high` is for the least restrictive
  /// correlation time between the shortest and the longest averaging time.
  AllanCoefficient markov_sigma;
  AllanCoefficient markov_time_s;  ///< its correlation time; not found: 0 to infinity
  /// Least value of the fitted curve within the averaging times divided by 0.664, with its interval: what data sheets
  /// call bias instability. `found` only if the curve has turned up again or is flat at its end; else an upper bound:
  /// `value` is what the falling curve has reached, `low` 0.
  AllanCoefficient bias_instability;
  double bias_instability_tau_s = 0.0;  ///< averaging time of that least value
  std::vector<double> deviation;        ///< of the fitted model at each averaging time
  /// Effective, of each measured variance under the fitted model, at least 1. Where the model misfits (p_value < 0.01)
  /// no more than white noise, flicker or a random walk alone would have, nor than 2 over the squared relative misfit.
  std::vector<double> degrees_of_freedom;
  std::vector<std::array<double, 2>> ci95;  ///< of each measured deviation (chi-squared at these degrees of freedom)
  std::size_t first_fitted = 0;             ///< index of the first averaging time beyond the low-pass
  double p_value = 1.0;                     ///< of the misfit: small = the six terms cannot make this curve
};

/// Fits the noise terms to a curve by generalised least squares: the covariance of the estimates at all averaging times
/// follows from the model (Gaussian noise), which matters because they are strongly dependent. Terms that the curve
/// does not need are left out (their share of belief stays in the intervals of the others); if the curve misfits,
/// outlying averaging times (a vibration line, a temperature cycle) count less and all variances are inflated by what
/// is left: a weak rise at the longest times then passes unnoticed, only the upper limits tell. Refuses fewer than 5
/// averaging times, times without a difference, lengths that differ, deviations that are not finite and positive (and
/// normal numbers), coefficients that no double holds.
///
/// Behind a low-pass (curve.low_pass) only averaging times from three periods of its corner on are fitted. There white
/// noise has N^2/tau (1 - 1.5 lag/tau), N^2 the density at low frequencies; the lag follows from the filter's form and
/// is taken to be known to 10 %. At shorter times `deviation` and `degrees_of_freedom` are those of the form. No
/// Gauss-Markov term is faster than kLeastCorner_hz: that is a filter's.
[[nodiscard]] base::Result<AllanFit> fit_allan(const AllanCurve& curve);

}  // namespace soak::calib::signal
