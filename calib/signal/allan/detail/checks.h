// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "base/result.h"

namespace soak::calib::signal::allan {

[[nodiscard]] base::Status check_rate_hz(double rate_hz);

/// NaN is a missing sample, infinity a mistake. `first` is the index of the first of these samples in the record.
[[nodiscard]] base::Status check_samples(std::span<const double> samples, std::size_t first);

}  // namespace soak::calib::signal::allan
