// SPDX-License-Identifier: Apache-2.0
#include "station/import/slow_channel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

namespace soak::station {
namespace {

constexpr double kHold_s = 2.0;  // a value holds so long at least

/// How long a channel's value holds: kHold_s, or 1.5 times the median distance in time between neighbouring values that
/// are present where that is longer.
double hold_limit_s(std::span<const double> t_s, std::span<const double> values) {
  std::vector<double> long_s;  // distances that hold for longer than kHold_s
  std::size_t distances = 0;
  std::optional<double> last;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (last) {
      ++distances;
      if (!(1.5 * (t_s[i] - *last) <= kHold_s)) long_s.push_back(t_s[i] - *last);
    }
    last = t_s[i];
  }
  // The median of all, if it is among the long ones: those are the last in order.
  const std::size_t middle = distances / 2;
  const std::size_t others = distances - long_s.size();
  if (distances == 0 || middle < others) return kHold_s;
  const auto median = long_s.begin() + static_cast<std::ptrdiff_t>(middle - others);
  std::nth_element(long_s.begin(), median, long_s.end());
  return std::max(kHold_s, 1.5 * *median);
}

}  // namespace

void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values) {
  if (std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) return;
  const double limit_s = hold_limit_s(t_s, values);
  double last = std::numeric_limits<double>::quiet_NaN();
  double last_t_s = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) {
      last = values[i];
      last_t_s = t_s[i];
    } else if (t_s[i] - last_t_s <= limit_s) {
      values[i] = last;
    }
  }
}

}  // namespace soak::station
