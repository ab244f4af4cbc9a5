// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace soak::calib::signal_json {

/// What straight lines over short gaps do to white noise. A mean of m samples, m well above the gaps, weighs each
/// present sample by w = 1 + half the bridged samples next to it, and has (1 + excess)/m of the variance, excess =
/// sum(w^2 - w)/sum(w): 1.5 times the share of lost samples if these are single. Differences at averaging times near
/// the gaps lose about as much.
struct Bridging {
  double share = 0.0;  ///< of bridged among all samples
  double excess = 0.0;
  std::size_t samples = 0;

  /// Whether that is less than what the fit knows or claims: an error of 0.1 % of the variance, or a quarter of the
  /// statistical one, sqrt(3/samples).
  [[nodiscard]] bool negligible() const;
  /// From this multiple on the variance of white noise is 1 + excess times what it would be without the lines, with an
  /// error, of about 2 excess/m, below a quarter of the statistical one, sqrt(4 m/(3 samples)); at least 10.
  [[nodiscard]] std::size_t first_multiple() const;
};

/// Of the gaps of up to `longest` missing samples (NaN) between present ones.
[[nodiscard]] Bridging bridging(std::span<const double> values, std::size_t longest);

}  // namespace soak::calib::signal_json
