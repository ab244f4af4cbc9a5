// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace soak::calib::gate {

/// Stretch of rows of a segment, counted from its first row.
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
  double duration_s = 0.0;
};

/// Cuts a segment into stretches of 10 s, at least six, each of two rows or more; empty for fewer than twelve rows.
[[nodiscard]] std::vector<Stretch> stretches(std::span<const double> t_s);

/// A sample far outside the noise.
struct Hit {
  std::size_t row = 0;
  double residual = 0.0;  ///< distance from the median of its stretch
};

/// One sensor's level, stretch by stretch, and what stands out of it.
struct Levels {
  double sigma = 0.0;        ///< spread about the levels; 0 = no noise, and nothing stands out
  std::vector<double> mean;  ///< per stretch, without short bursts; NaN = no sample
  std::vector<Hit> hits;     ///< in the order of rows, short or long
};

/// Hits follow each other within this time, or from row to row, to make one burst.
inline constexpr double kBurstGap_s = 0.05;

/// `values` has one value per row, NaN = no sample. sigma is 1.48 times the median distance from the medians of the
/// stretches (of at most some hundred samples of each), and at least `least_sigma`; samples beyond `sigmas` of it are
/// hits. Bursts of hits up to a quarter of a second, or of three rows, are no part of the means: a bad sample or a
/// knock is not motion. Whoever turns a unit by hand takes longer.
[[nodiscard]] Levels levels_of(std::span<const double> t_s, std::span<const double> values,
                               std::span<const Stretch> stretches, double least_sigma, double sigmas);

}  // namespace soak::calib::gate
