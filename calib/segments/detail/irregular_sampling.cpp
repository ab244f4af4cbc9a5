// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

constexpr std::size_t kFewestIntervals = 10;

}  // namespace

std::optional<double> share_off(std::span<const double> times, double interval_s) {
  if (times.size() <= kFewestIntervals) return std::nullopt;
  double off = 0.0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (std::abs(times[i] - times[i - 1] - interval_s) > 0.5 * interval_s) off += 1.0;
  }
  return off / static_cast<double>(times.size() - 1);
}

std::optional<Finding> irregular_sampling(const Samples& samples, double share) {
  if (share <= samples.view.limits.irregular_share) return std::nullopt;
  return Finding{"irregular_sampling", Severity::warn, std::nullopt,
                 fmt::format("{:.0f} % of the intervals of {} differ from the usual {:.3g} s by more than half "
                             "of it: standard errors, spectra and wavelets take samples as equally spaced",
                             100.0 * share, name_of(samples.sensor), samples.facts().interval_s)};
}

}  // namespace soak::calib::gate
