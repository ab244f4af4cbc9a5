// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

/// Single passes over samples, in the order of additions that vector registers keep.
namespace soak::calib::gate {

/// Samples about a level. NaN samples make `sum` NaN and are not seen by `peak`.
struct Deviation {
  double sum = 0.0;   ///< of the samples less the level
  double peak = 0.0;  ///< largest distance from the level
};
[[nodiscard]] Deviation deviation_from(std::span<const double> values, double level);

/// Changes between neighbouring samples.
struct Changes {
  std::size_t none = 0;   ///< neighbours that are equal
  double smallest = 0.0;  ///< smallest change; 0 without any
};
[[nodiscard]] Changes changes_of(std::span<const double> values);

/// Extreme values; of at least one sample.
struct Extremes {
  double low = 0.0;
  double high = 0.0;
};
[[nodiscard]] Extremes extremes_of(std::span<const double> values);

}  // namespace soak::calib::gate
