// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

/// Least noise, in steps, of a sensor that shows three codes or more in most stretches: with less it stands on one code
/// for long, or flickers between two.
constexpr double kLeastNoise = 0.35;
/// Runs longer than this many usual ones (a device that repeats its values has long usual ones).
constexpr double kUsualRuns = 5.0;

/// Shortest run that counts as stuck; 0 = the resolution cannot tell.
///
/// With white noise σ rounded to steps q, a sample repeats the one before with a chance of at most p = erf(q/(2√2 σ)),
/// that of the step in the middle. A run of L among N samples has a chance of N·p^(L−1) at most. The rounded noise s
/// has σ² = s² − q²/12 (Sheppard), which holds from σ = 0.35 q on.
std::size_t shortest_stuck(const View& view, Sensor sensor, std::size_t samples) {
  const SensorFacts& facts = view.facts_of(sensor);
  const double step = step_of(view, sensor);
  if (step <= 0.0 || facts.noise <= 0.0 || !facts.many_codes) return 0;
  const double sheppard = facts.noise * facts.noise - step * step / 12.0;
  const double noise = std::max(kLeastNoise * step, std::sqrt(std::max(0.0, sheppard)));
  const double repeat = std::erf(step / (2.0 * std::numbers::sqrt2 * noise));
  const double by_chance = 1.0 + std::log(view.limits.stuck_chance / static_cast<double>(samples)) / std::log(repeat);
  const double shortest = std::max(
      {static_cast<double>(view.limits.stuck_samples), by_chance, kUsualRuns * static_cast<double>(facts.usual_run)});
  return static_cast<std::size_t>(std::ceil(shortest));
}

/// Samples in runs of at least `shortest`, and the longest run.
struct Runs {
  std::size_t samples = 0;
  std::size_t longest = 0;
  double value = 0.0;
};

/// A run of `shortest` or more covers two samples half of that apart; only there it is looked at closely.
Runs long_runs(std::span<const double> x, std::size_t shortest) {
  const std::size_t stride = std::max<std::size_t>(1, shortest / 2);
  Runs runs;
  for (std::size_t i = 0; i + stride < x.size();) {
    const std::size_t next = i + stride;
    if (x[i] != x[next]) {
      i = next;
      continue;
    }
    std::size_t first = i;
    std::size_t last = i + 1;
    while (first > 0 && x[first - 1] == x[i]) --first;
    while (last < x.size() && x[last] == x[i]) ++last;
    const std::size_t length = last - first;
    if (length >= shortest) runs.samples += length;
    if (length >= shortest && length > runs.longest) {
      runs.longest = length;
      runs.value = x[first];
    }
    i = std::max(next, last);
  }
  return runs;
}

std::string text_of(Sensor sensor, const Runs& runs, std::size_t samples, std::size_t shortest) {
  return fmt::format(
      "{} repeats {:.6g} {} up to {} times in a row ({} of {} samples in such runs); its noise explains "
      "at most {}",
      name_of(sensor), runs.value * printed_per_si(sensor), printed_unit(sensor), runs.longest, runs.samples, samples,
      shortest - 1);
}

/// One number in a whole recording; in a single position at one temperature a coarse resolution explains that too.
Finding throughout(const View& view, Sensor sensor, double value) {
  const bool certain = view.facts.plateaus_differ || (view.facts.positions_differ && !is_gyro(sensor));
  return {
      "stuck", certain ? Severity::reject : Severity::warn, sensor,
      fmt::format("{} gives {:.6g} {} throughout the recording: {}", name_of(sensor), value * printed_per_si(sensor),
                  printed_unit(sensor),
                  certain ? "a live sensor would differ between temperatures, an accelerometer between positions too"
                          : "a live sensor has noise, if its resolution shows it")};
}

/// Whether the number that an accelerometer gives all through this segment is also all that it gives in another
/// position, where gravity along its axis is another.
bool ignores_gravity(const View& view, Sensor sensor) {
  constexpr double kOther = 0.5;  ///< of g
  const std::size_t s = index_of(sensor);
  const SensorStatistics& here = view.segment.sensor[s];
  if (is_gyro(sensor) || !view.segment.position || here.count == 0 || here.variance != 0.0) return false;
  return std::any_of(view.segments.begin(), view.segments.end(), [&](const Segment& other) {
    const SensorStatistics& there = other.sensor[s];
    const bool same = there.count > 0 && there.variance == 0.0 && there.mean == here.mean;
    return same && other.position &&
           std::abs(other.position->up[axis_of(sensor)] - view.segment.position->up[axis_of(sensor)]) > kOther;
  });
}

}  // namespace

std::optional<Finding> stuck(const Samples& samples) {
  const auto& [view, sensor, present] = samples;
  const std::span<const double> x = present.values();
  if (x.size() < static_cast<std::size_t>(view.limits.stuck_samples)) return std::nullopt;
  if (samples.facts().one_number) return throughout(view, sensor, x.front());
  if (ignores_gravity(view, sensor)) {
    return Finding{"stuck", Severity::reject, sensor,
                   fmt::format("{} gives {:.6g} {} all through this segment, as in another position, where gravity "
                               "along its axis is another",
                               name_of(sensor), x.front() * printed_per_si(sensor), printed_unit(sensor))};
  }
  const std::size_t shortest = shortest_stuck(view, sensor, x.size());
  if (shortest == 0) return std::nullopt;
  const Runs runs = long_runs(x, shortest);
  if (runs.samples == 0) return std::nullopt;
  const double share = static_cast<double>(runs.samples) / static_cast<double>(x.size());
  return Finding{"stuck", share > view.limits.pinned_share ? Severity::reject : Severity::warn, sensor,
                 text_of(sensor, runs, x.size(), shortest)};
}

}  // namespace soak::calib::gate
