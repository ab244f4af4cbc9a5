// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "calib/gate/checks.h"

namespace soak::calib::gate {
namespace {

constexpr std::size_t kFewestIntervals = 10;

/// Share of the intervals that differ from the usual one by more than half of it.
double share_off(std::span<const double> times, double interval_s) {
  double off = 0.0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (std::abs(times[i] - times[i - 1] - interval_s) > 0.5 * interval_s) off += 1.0;
  }
  return off / static_cast<double>(times.size() - 1);
}

}  // namespace

void irregular_sampling(const View& view, std::vector<Finding>& findings) {
  std::span<const double> regular;  // times of a sensor that is; those without missing samples share them
  for (const Sensor sensor : kSensors) {
    const double interval_s = view.facts_of(sensor).interval_s;
    if (view.values(sensor).empty() || interval_s <= 0.0 || has(findings, "dropouts", sensor)) continue;
    const std::span<const double> times = view.present_of(sensor).t_s();
    if (times.size() <= kFewestIntervals || (times.data() == regular.data() && times.size() == regular.size()))
      continue;
    const double share = share_off(times, interval_s);
    regular = times;
    if (share <= view.limits.irregular_share) continue;
    findings.push_back({"irregular_sampling", Severity::warn, std::nullopt,
                        fmt::format("{:.0f} % of the intervals of {} differ from the usual {:.3g} s by more than half "
                                    "of it: standard errors, spectra and wavelets take samples as equally spaced",
                                    100.0 * share, name_of(sensor), interval_s)});
    return;
  }
}

}  // namespace soak::calib::gate
