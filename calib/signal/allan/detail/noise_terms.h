// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace soak::calib::signal::allan_fit {

/// The noise terms, each with one variance theta. Time is counted in sample intervals throughout this folder.
enum Term : std::size_t { quantization, white, flicker, random_walk, ramp, markov, kTerms };

/// One number per term.
using PerTerm = std::array<double, kTerms>;

/// Allan variance of each term at theta = 1 and averaging time m > 0 [IEEE 952-1997 annex C]: 3/m^2, 1/m, 2 ln2/pi,
/// m/3, m^2/2, and for the first-order Gauss-Markov process of variance 1 and correlation time T
/// 2 T/m (1 - T/(2 m) (3 - 4 exp(-m/T) + exp(-2 m/T))). T = 0: no such term, its entry is 0.
///
/// `lag`: of a low-pass behind the white noise, whose variance beyond the filter's memory is 1/m - 1.5 lag/m^2 (see
/// low_pass_curve.h).
[[nodiscard]] PerTerm allan_variances(double m, double markov_time, double lag = 0.0);

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

/// How many pairs of second differences a record without gaps, or one of several stretches, has at each lag.
class PairCounts {
 public:
  /// `stretches`: phase points of each.
  explicit PairCounts(std::span<const std::size_t> stretches);

  /// Pairs z_a(i), z_b(i + u) within one stretch; the number of differences themselves for m_a = m_b, u = 0.
  [[nodiscard]] double pairs(double m_a, double m_b, double u) const;
  [[nodiscard]] double differences(double m) const { return longer_than(2.0 * m); }
  [[nodiscard]] double longest() const { return lengths_.back(); }

 private:
  /// Sum of n - w over the stretches with n > w.
  [[nodiscard]] double longer_than(double w) const;

  std::vector<double> lengths_;  ///< rising
  std::vector<double> sums_;     ///< sums_[k]: of lengths_[k..]
};

/// Symmetric table over pairs of terms, lower triangle row by row.
using TermPairs = std::array<double, kTerms*(kTerms + 1) / 2>;

/// What Cov(sigma_a^2, sigma_b^2) = sum_{k >= l} table_kl theta_k theta_l is made of, for Gaussian noise with a ramp:
///   Cov = 2 / (4 m_a^2 m_b^2 M_a M_b) sum_u n_ab(u) (c_ab(u)^2 + 2 d_a d_b c_ab(u)),  d_a = R m_a^2
/// (Isserlis; odd moments vanish), M the numbers of differences. The ramp enters c as c_ramp = d_a d_b, its own square
/// left out. Sums over long smooth ranges of lags are integrals (6 points per panel, panels growing away from the
/// kinks u = p m_a - q m_b); short panels are summed lag by lag. Good to 0.1 % of the larger variance.
[[nodiscard]] TermPairs covariance_terms(const PairCounts& counts, double m_a, double m_b, double markov_time);

/// The covariances of the overlapping Allan variances at several averaging times, ready for any theta.
class CovarianceTable {
 public:
  CovarianceTable(const PairCounts& counts, std::vector<double> multiples, double markov_time);

  [[nodiscard]] Eigen::MatrixXd covariance(const PerTerm& theta) const;
  [[nodiscard]] const std::vector<double>& multiples() const { return multiples_; }
  [[nodiscard]] double markov_time() const { return markov_time_; }

 private:
  std::vector<double> multiples_;
  double markov_time_;
  std::vector<TermPairs> entries_;  ///< lower triangle row by row
};

/// sum_{k >= l} pairs_kl theta_k theta_l.
[[nodiscard]] double quadratic_form(const TermPairs& pairs, const PerTerm& theta);

}  // namespace soak::calib::signal::allan_fit
