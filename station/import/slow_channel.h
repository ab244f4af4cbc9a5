// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace soak::station {

/// Fills rows without a new value (NaN) with the last one, for 2 s at most, or for 1.5 times the median spacing of the
/// channel's own values where that is longer. Rows before the first value stay NaN.
void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values);

}  // namespace soak::station
