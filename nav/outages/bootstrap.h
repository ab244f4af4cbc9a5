// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace soak::nav {

/// A number with its two-sided 95 % interval.
struct Estimate {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// A statistic of `count` (≥ 1) cases, with the percentile interval of the bootstrap (Efron 1979): 2000 times as many
/// cases are drawn with replacement. `statistic` gets indices of cases; pairs of quantities of one case stay together.
/// With fewer than 5 cases the interval is NaN: percentiles of so few say nothing. Seeded, the same on every machine.
[[nodiscard]] Estimate bootstrap(std::size_t count,
                                 const std::function<double(std::span<const std::size_t>)>& statistic,
                                 std::uint64_t seed);

}  // namespace soak::nav
