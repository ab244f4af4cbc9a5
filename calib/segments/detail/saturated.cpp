// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calib/segments/detail/checks.h"
#include "calib/segments/detail/scan.h"

namespace soak::calib::gate {
namespace {

constexpr double kAtRange = 0.9999;  ///< of the range: a rounded full scale still counts

/// Signs of clipping: noise that shows on one side of the extreme value only.
constexpr std::size_t kStretch = 100;      ///< samples; within so many drift is small
constexpr double kPileUp = 6.5;            ///< sigmas by which the extreme value outnumbers the next one
constexpr std::size_t kFewestReturns = 3;  ///< from beyond the next value: a quiet sensor flickers between two

constexpr std::size_t kPart = 512;  ///< samples that are looked at together

/// End of the range in SI where the type states it.
std::optional<double> range_of(const View& view, Sensor sensor) {
  if (!is_gyro(sensor)) return view.type.accel_range_mps2;
  if (!view.type.gyro_range_dps) return std::nullopt;
  return *view.type.gyro_range_dps / printed_per_si(sensor);
}

std::size_t beyond(std::span<const double> x, double range) {
  return static_cast<std::size_t>(
      std::count_if(x.begin(), x.end(), [&](double value) { return std::abs(value) >= kAtRange * range; }));
}

/// The value next to the extreme one; the extreme one itself where there is none.
double next_to(std::span<const double> x, double extreme) {
  double next = extreme;
  for (const double value : x) {
    const bool nearer = next == extreme || std::abs(value - extreme) < std::abs(next - extreme);
    if (value != extreme && nearer) next = value;
  }
  return next;
}

/// How often the samples come back to the extreme value from beyond the next one.
std::size_t returns_to(std::span<const double> x, double extreme, double next) {
  std::size_t returns = 0;
  bool beyond_next = false;
  for (const double value : x) {
    if (value == extreme && beyond_next) ++returns;
    beyond_next = value != extreme && (beyond_next || value != next);
  }
  return returns;
}

/// Extreme values of each part of some hundred samples: most parts need no second look.
std::vector<Extremes> extremes_by_part(std::span<const double> x) {
  std::vector<Extremes> parts;
  for (std::size_t first = 0; first < x.size(); first += kPart) {
    parts.push_back(extremes_of(x.subspan(first, std::min(kPart, x.size() - first))));
  }
  return parts;
}

std::size_t count_of(std::span<const double> x, double extreme, const std::vector<Extremes>& parts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].low != extreme && parts[i].high != extreme) continue;
    const auto part = x.subspan(i * kPart, std::min(kPart, x.size() - i * kPart));
    count += static_cast<std::size_t>(std::count(part.begin(), part.end(), extreme));
  }
  return count;
}

/// Samples that are pinned at `extreme`; 0 where they may be there by chance.
///
/// Noise that is not cut off has, at its extreme value, no more samples than at the next one. So of P samples there and
/// B beside them, stretch by stretch, P is at most a fair coin's share: (P − B)/√(P + B) is a standard normal number.
std::size_t pinned_at(std::span<const double> x, double extreme, const std::vector<Extremes>& parts) {
  const auto pinned = static_cast<double>(count_of(x, extreme, parts));
  if (pinned < kPileUp * kPileUp) return 0;
  std::size_t beside = 0;
  std::size_t returns = 0;
  const std::span<const double> all(x);
  for (std::size_t first = 0; first < x.size(); first += kStretch) {
    const auto stretch = all.subspan(first, std::min(kStretch, x.size() - first));
    if (std::find(stretch.begin(), stretch.end(), extreme) == stretch.end()) continue;
    const double next = next_to(stretch, extreme);
    if (next != extreme) beside += static_cast<std::size_t>(std::count(stretch.begin(), stretch.end(), next));
    returns += returns_to(stretch, extreme, next);
  }
  const auto others = static_cast<double>(beside);
  const bool piled_up = pinned - others >= kPileUp * std::sqrt(pinned + others);
  return piled_up && returns >= kFewestReturns ? static_cast<std::size_t>(pinned) : 0;
}

Finding report(const Samples& samples, std::size_t hits, std::string_view what, double value) {
  const std::size_t count = samples.present.values().size();
  const double share = static_cast<double>(hits) / static_cast<double>(count);
  return {"saturated", share > samples.view.limits.pinned_share ? Severity::reject : Severity::warn, samples.sensor,
          fmt::format("{}: {} of {} samples {} {:.6g} {}; at rest none should be", name_of(samples.sensor), hits, count,
                      what, value * printed_per_si(samples.sensor), printed_unit(samples.sensor))};
}

}  // namespace

std::optional<Finding> saturated(const Samples& samples) {
  const std::span<const double> x = samples.present.values();
  if (x.empty()) return std::nullopt;
  const auto range = range_of(samples.view, samples.sensor);
  if (const std::size_t hits = range ? beyond(x, *range) : 0; hits > 0) {
    return report(samples, hits, "reach the range of", *range);
  }
  const std::vector<Extremes> parts = extremes_by_part(x);
  Extremes extremes = parts.front();
  for (const Extremes& part : parts) {
    extremes = {std::min(extremes.low, part.low), std::max(extremes.high, part.high)};
  }
  for (const double extreme : {extremes.low, extremes.high}) {
    if (const std::size_t hits = pinned_at(x, extreme, parts); hits > 0)
      return report(samples, hits, "are cut off at", extreme);
  }
  return std::nullopt;
}

}  // namespace soak::calib::gate
