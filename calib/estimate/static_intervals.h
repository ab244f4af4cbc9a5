// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/estimate/multi_position.h"
#include "calib/vocabulary/position.h"

namespace soak::calib {

/// Samples [first, last) during which the unit rested.
struct StaticInterval {
  std::size_t first = 0;
  std::size_t last = 0;

  bool operator==(const StaticInterval&) const = default;
};

/// What counts as rest. Lengths are in samples.
struct StaticIntervalOptions {
  std::size_t initial = 1000;  ///< stretch at the start in which the unit is known to rest: it shows the noise
  std::size_t window = 100;    ///< length over which the spread of the samples is judged; ≥ 2, ≤ initial
  double factor = 3.0;         ///< of the initial spread up to which the unit rests; > 1
  std::size_t shortest = 200;  ///< shorter intervals are dropped; ≥ 1
};

/// Finds the intervals at rest in a recording of a triad that was turned from attitude to attitude, after the idea of
/// Tedaldi, Pretto, Menegatti, ICRA 2014: the spread s(n) = √(v_x + v_y + v_z), v the variances over the window about
/// sample n, stays below `factor` times the spread of the initial stretch. A sample belongs to an interval if the whole
/// window about it is quiet. Cost linear in the number of samples, independent of the window.
///
/// Refuses options outside their ranges, a recording shorter than its initial stretch, samples that are not finite, and
/// an initial stretch without any noise.
[[nodiscard]] base::Result<std::vector<StaticInterval>> find_static_intervals(std::span<const Vector3> samples,
                                                                              const StaticIntervalOptions& options);

/// Mean and standard error (calib/segments/statistics.h: correlation of the noise counts) of each interval. The
/// intervals lie within the samples and are not empty.
[[nodiscard]] std::vector<AttitudeMean> attitude_means(std::span<const Vector3> samples,
                                                       std::span<const StaticInterval> intervals);

}  // namespace soak::calib
