// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace soak::calib::signal::allan_fit {

/// The noise terms, each with one variance theta. Time is counted in sample intervals throughout this folder.
enum Term : std::size_t { quantization, white, flicker, random_walk, ramp, markov, kTerms };

/// One number per term.
using PerTerm = std::array<double, kTerms>;

/// Allan variance of each term at theta = 1 and averaging time m > 0 [IEEE 952-1997 annex C]: 3/m^2, 1/m, 2 ln2/pi,
/// m/3, m^2/2, and for the first-order Gauss-Markov process of variance 1 and correlation time T
/// 2 T/m (1 - T/(2 m) (3 - 4 exp(-m/T) + exp(-2 m/T))). T = 0: no such term, its entry is 0.
[[nodiscard]] PerTerm allan_variances(double m, double markov_time);

/// For each random term at theta = 1 the covariance of second differences of phase,
///   c_ab(u) = Cov(z_a(i), z_b(i + u)),  z_a(i) = x(i + 2 m_a) - 2 x(i + m_a) + x(i),  m_a <= m_b,
///           = sum_{p,q} k_p k_q S(u + q m_b - p m_a),  k = (1, -2, 1),
/// from the generalised autocovariance S(t) of phase (up to powers of t that second differences do not see):
///   white -|t|/2, flicker t^2 ln|t|/(2 pi), random walk |t|^3/12, Gauss-Markov -T^2 (exp(-|t|/T) + |t|/T).
/// The entry of quantization is 0: it is a comb, see quantization_comb(). That of the ramp, which is not random, is the
/// product m_a^2 m_b^2 of its two second differences.
[[nodiscard]] PerTerm difference_covariances(double m_a, double m_b, double u, double markov_time);

/// c_ab(u) of quantization (S = 1 at 0, else 0) at a whole lag u.
[[nodiscard]] double quantization_comb(double m_a, double m_b, double u);

}  // namespace soak::calib::signal::allan_fit
