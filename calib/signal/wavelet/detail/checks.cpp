// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/checks.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

namespace soak::calib::signal::denoising {

base::Status check_not_negative(std::span<const double> values, std::string_view what) {
  for (std::size_t j = 0; j < values.size(); ++j) {
    if (std::isfinite(values[j]) && values[j] >= 0.0) continue;
    return base::bad_input(fmt::format("{} is {}; it must be finite and at least 0", what, values[j]),
                           fmt::format("level {}", j + 1));
  }
  return {};
}

}  // namespace soak::calib::signal::denoising
