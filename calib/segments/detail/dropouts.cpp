// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

constexpr double kGapIntervals = 1.5;

}  // namespace

/// What an interval has beyond the usual one is lost; so is the time before the first and after the last value. Bursts
/// make such gaps without a loss: no more can be missing than the number of values is short of.
Loss loss_of(std::span<const double> t_s, std::span<const double> times, double interval_s) {
  Loss loss;
  const double total_s = t_s.back() - t_s.front() + interval_s;
  double last_s = t_s.front() - interval_s;
  const auto pass = [&](double next_s) {
    const double gap_s = next_s - last_s;
    if (gap_s > kGapIntervals * interval_s) loss.share += (gap_s - interval_s) / total_s;
    loss.longest_s = std::max(loss.longest_s, gap_s);
    last_s = next_s;
  };
  for (const double time : times) pass(time);
  pass(t_s.back() + interval_s);
  loss.share = std::min(loss.share, 1.0 - static_cast<double>(times.size()) * interval_s / total_s);
  return loss;
}

std::optional<Finding> dropouts(const Samples& samples, const Loss& loss) {
  const GateLimits& limits = samples.view.limits;
  if (loss.share <= limits.missing_warn_share) return std::nullopt;
  const bool rejected = loss.share > limits.missing_reject_share;
  return Finding{"dropouts", rejected ? Severity::reject : Severity::warn, samples.sensor,
                 fmt::format("{}: {:.1f} % of the samples are missing, for up to {:.3g} s (one every {:.3g} s "
                             "would be right; more than {:.0f} % missing are not used)",
                             name_of(samples.sensor), 100.0 * loss.share, loss.longest_s, samples.facts().interval_s,
                             100.0 * limits.missing_reject_share)};
}

}  // namespace soak::calib::gate
