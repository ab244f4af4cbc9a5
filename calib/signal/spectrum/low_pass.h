// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace soak::calib::signal {

/// Forms of a low-pass, x the frequency over the corner: Butterworth 1/(1 + x^2n), equal poles 1/(1 + a x^2)^n, n means
/// over equal times sinc(b x)^2n; a and b such that x = 1 halves the power.
enum class LowPassForm : std::uint8_t { butterworth, equal_poles, means };

/// The low-pass that a unit has applied to its own noise.
struct LowPass {
  double corner_hz = 0.0;  ///< where the form halves the power before sampling
  double rate_hz = 0.0;    ///< of the samples: what lies beyond half of it comes back below
  LowPassForm form = LowPassForm::butterworth;
  int order = 1;       ///< n of the form that comes closest
  double floor = 0.0;  ///< share of the density at frequency 0 that came in behind the filter (rounding, converter)

  /// Power density of the samples at this frequency over that at 0, of noise that is white before the filter.
  [[nodiscard]] double gain(double frequency_hz) const;
  /// Where that is 1/2 for the first time; nothing: nowhere below rate/2.
  [[nodiscard]] std::optional<double> half_power_hz() const;
};

/// No unit filters its rate as slowly as this; what bends the spectrum below is a noise process of its own.
inline constexpr double kLeastCorner_hz = 3.0;

/// Looks for the low-pass in a record: the spectrum (Welch, medians over bands an eighth of an octave wide, which lines
/// do not touch) is compared with what noise without a filter can make, any non-negative sum of white noise, flicker,
/// random walk, slow Gauss-Markov processes and quantization, and with the same sum behind each form of filter at
/// each corner from kLeastCorner_hz to 1.5 of the rate. Nothing where no filter makes it clearly better (chi^2 less by
/// 12), for rates below 4 kLeastCorner_hz and for records too short for a spectrum. Sections in which a sample is
/// missing (NaN) are left out. The corner is that of the density after sampling. O(n log n).
[[nodiscard]] std::optional<LowPass> find_low_pass(std::span<const double> samples, double rate_hz);

}  // namespace soak::calib::signal
