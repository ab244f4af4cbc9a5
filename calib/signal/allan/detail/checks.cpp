// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace soak::calib::signal::allan {

base::Status check_rate_hz(double rate_hz) {
  if (std::isfinite(rate_hz) && rate_hz > 0.0) return {};
  return base::bad_input(fmt::format("the sampling rate is {} Hz: it must be finite and above 0", rate_hz), "rate_hz");
}

base::Status check_samples(std::span<const double> samples, std::size_t first) {
  const auto infinite = std::find_if(samples.begin(), samples.end(), [](double v) { return std::isinf(v); });
  if (infinite == samples.end()) return {};
  const auto index = first + static_cast<std::size_t>(infinite - samples.begin());
  return base::bad_input("the sample is infinite: values must be finite, or NaN where one is missing",
                         fmt::format("sample {}", index));
}

}  // namespace soak::calib::signal::allan
