// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/instruction_set.h"

namespace soak::calib::signal {

/// Interleaved partial sums of the additions below: an order that the compiler can keep in vector registers.
inline constexpr std::size_t kSumLanes = 8;

/// Sum of term(i), i = 0..n - 1.
template <class Term>
[[nodiscard]] SOAK_INLINE double lane_sum(std::size_t n, const Term& term) {
  std::array<double, kSumLanes> partial{};
  std::size_t i = 0;
  for (; i + kSumLanes <= n; i += kSumLanes) {
    for (std::size_t lane = 0; lane < kSumLanes; ++lane) partial[lane] += term(i + lane);
  }
  for (; i < n; ++i) partial[0] += term(i);
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

/// sum_i a_i b_i, both of the same length.
[[nodiscard]] SOAK_INLINE double product_sum(std::span<const double> a, std::span<const double> b) {
  return lane_sum(a.size(), [&](std::size_t i) { return a[i] * b[i]; });
}

/// Power of a noise of unit strength in each band of NoiseModels, and its Allan variance.
struct NoiseShape;

/// What the noise of a stretch may be, seen through the means of its M equal parts: white noise alone, or with flicker,
/// with a random walk, or with a first-order Gauss-Markov process, each at several strengths (and correlation times)
/// against the white noise. What tells them apart is how the power is spread over the M - 2 coefficients
///   c_k = sqrt(2/M) sum_i cos(pi k (i + 1/2)/M) z_i,  k = 2..M-1,  z the means less their straight line,
/// whose expected squares follow from the covariance of the means. The tables depend on M alone.
class NoiseModels {
 public:
  /// O(M^3); `parts` M >= 32.
  explicit NoiseModels(std::size_t parts);

  [[nodiscard]] std::size_t parts() const { return parts_; }

  /// Allan deviation at the length of the whole stretch: the mean over all models of what each says, its scale fitted,
  /// weighted by how probable the coefficients make it (Gaussian, independent of each other, scale with the prior
  /// 1/scale integrated out). `means` has parts() values. 0 where nothing but a straight line varies. O(M^2).
  [[nodiscard]] double allan_deviation(std::span<const double> means) const;

 private:
  /// Neighbouring coefficients, pooled because the spectra hardly change between them.
  struct Band {
    std::size_t first = 0;  ///< row of `cosines_`
    std::size_t count = 0;
  };
  struct Model {
    std::vector<double> weight;    ///< of the power in each band: 1/(expected square at unit scale)
    double log_evidence = 0.0;     ///< ln prior - 1/2 sum over the coefficients of ln(expected square)
    double allan_deviation = 0.0;  ///< at unit scale
  };

  void make_cosines();
  void make_bands();
  [[nodiscard]] std::span<const double> cosine(std::size_t row) const;
  [[nodiscard]] NoiseShape shape_of(double (*phase)(double t, double time), double time) const;
  void add_family(const NoiseShape& white, const NoiseShape& coloured, double longest_crossing, double prior);
  void add(const NoiseShape& white, const NoiseShape& coloured, double ratio, double prior);
  [[nodiscard]] std::vector<double> band_powers(std::span<const double> means) const;

  std::size_t parts_;
  std::vector<double> cosines_;  ///< a row of M values per coefficient, each free of a straight line
  std::vector<Band> bands_;
  std::vector<Model> models_;
};

}  // namespace soak::calib::signal
