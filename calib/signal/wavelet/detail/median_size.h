// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace soak::calib::signal::denoising {

/// Median of |v| (mean of the two middle ones for an even count), 0 for no values. Exact; O(n): a sample of the values
/// brackets the median, one pass without branches picks out the few between, and only these are partitioned.
[[nodiscard]] double median_size(std::span<const double> values);

}  // namespace soak::calib::signal::denoising
