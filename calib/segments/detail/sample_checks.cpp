// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "calib/segments/detail/gate.h"
#include "calib/segments/detail/sample_scan.h"
#include "calib/segments/statistics.h"

namespace soak::calib::gate {
namespace {

// Samples at the end of the range.

constexpr double kAtRange = 0.9999;  ///< of the range: a rounded full scale still counts

/// Signs of clipping: noise that shows on one side of the extreme value only.
constexpr std::size_t kClipStretch = 100;  ///< samples; within so many drift is small
constexpr double kPileUp = 6.5;            ///< sigmas by which the extreme value outnumbers the next one
constexpr std::size_t kFewestReturns = 3;  ///< from beyond the next value: a quiet sensor flickers between two

constexpr std::size_t kScanPart = 512;  ///< samples that are looked at together

/// End of the range in SI where the type states it.
std::optional<double> range_of(const View& view, Sensor sensor) {
  if (!is_gyro(sensor)) return view.type.accel_range_mps2;
  if (!view.type.gyro_range_dps) return std::nullopt;
  return *view.type.gyro_range_dps / printed_per_si(sensor);
}

std::size_t count_beyond(std::span<const double> x, double range) {
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
  for (std::size_t first = 0; first < x.size(); first += kScanPart) {
    parts.push_back(extremes_of(x.subspan(first, std::min(kScanPart, x.size() - first))));
  }
  return parts;
}

std::size_t count_at(std::span<const double> x, double extreme, const std::vector<Extremes>& parts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].low != extreme && parts[i].high != extreme) continue;
    const auto part = x.subspan(i * kScanPart, std::min(kScanPart, x.size() - i * kScanPart));
    count += static_cast<std::size_t>(std::count(part.begin(), part.end(), extreme));
  }
  return count;
}

/// Samples that are pinned at `extreme`; 0 where they may be there by chance.
///
/// Noise that is not cut off has, at its extreme value, no more samples than at the next one. So of P samples there and
/// B beside them, stretch by stretch, P is at most a fair coin's share: (P − B)/√(P + B) is a standard normal number.
std::size_t pinned_at(std::span<const double> x, double extreme, const std::vector<Extremes>& parts) {
  const auto pinned = static_cast<double>(count_at(x, extreme, parts));
  if (pinned < kPileUp * kPileUp) return 0;
  std::size_t beside = 0;
  std::size_t returns = 0;
  for (std::size_t first = 0; first < x.size(); first += kClipStretch) {
    const auto stretch = x.subspan(first, std::min(kClipStretch, x.size() - first));
    if (std::find(stretch.begin(), stretch.end(), extreme) == stretch.end()) continue;
    const double next = next_to(stretch, extreme);
    if (next != extreme) beside += static_cast<std::size_t>(std::count(stretch.begin(), stretch.end(), next));
    returns += returns_to(stretch, extreme, next);
  }
  const auto others = static_cast<double>(beside);
  const bool piled_up = pinned - others >= kPileUp * std::sqrt(pinned + others);
  return piled_up && returns >= kFewestReturns ? static_cast<std::size_t>(pinned) : 0;
}

Finding saturation(const Samples& samples, std::size_t hits, std::string_view what, double value) {
  const std::size_t count = samples.present.values().size();
  const double share = static_cast<double>(hits) / static_cast<double>(count);
  return {"saturated", share > samples.view.limits.pinned_share ? Severity::reject : Severity::warn, samples.sensor,
          fmt::format("{}: {} of {} samples {} {:.6g} {}; at rest none should be", name_of(samples.sensor), hits, count,
                      what, value * printed_per_si(samples.sensor), printed_unit(samples.sensor))};
}

// One number repeated.

/// Least noise, in steps, of a sensor that shows three codes or more in most stretches: with less it stands on one code
/// for long, or flickers between two.
constexpr double kLeastNoise = 0.35;
/// Repeats longer than this many usual ones (a device that repeats its values has long usual ones).
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
struct Repeats {
  std::size_t samples = 0;
  std::size_t longest = 0;
  double value = 0.0;
};

/// A run of `shortest` or more covers two samples half of that apart; only there it is looked at closely.
Repeats long_runs(std::span<const double> x, std::size_t shortest) {
  const std::size_t stride = std::max<std::size_t>(1, shortest / 2);
  Repeats runs;
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

std::string repeats_text(Sensor sensor, const Repeats& runs, std::size_t samples, std::size_t shortest) {
  return fmt::format(
      "{} repeats {:.6g} {} up to {} times in a row ({} of {} samples in such runs); its noise explains at most {}",
      name_of(sensor), runs.value * printed_per_si(sensor), printed_unit(sensor), runs.longest, runs.samples, samples,
      shortest - 1);
}

/// One number in a whole recording; in a single position at one temperature a coarse resolution explains that too.
Finding one_number(const View& view, Sensor sensor, double value) {
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

// Times without values.

constexpr double kGapIntervals = 1.5;
constexpr std::size_t kFewestIntervals = 10;

void add_each(const View& view, std::optional<Finding> SensorSummary::* check, std::vector<Finding>& findings) {
  for (const SensorSummary& summary : view.state.sensor) {
    if (summary.*check) findings.push_back(*(summary.*check));
  }
}

/// Whether another sensor stands out in the same row: then it was a knock.
bool hit_elsewhere(const View& view, Sensor sensor, std::size_t row) {
  return std::ranges::any_of(kSensors, [&](Sensor other) {
    const auto& hits = view.levels_of(other).hits;
    return other != sensor && std::ranges::binary_search(hits, row, {}, &Hit::row);
  });
}

void add_spikes(const View& view, std::vector<Finding>& findings) {
  for (const Sensor sensor : kSensors) {
    std::vector<std::size_t> rows = view.summary_of(sensor).spikes;
    std::erase_if(rows, [&](std::size_t row) { return hit_elsewhere(view, sensor, row); });
    if (rows.empty()) continue;
    findings.push_back(
        {"spike", Severity::warn, sensor,
         fmt::format("{}: {} of {} samples stand{} alone beyond {:.0f} sigma, the first at {:.2f} s: left out of the "
                     "means; a flipped bit on the wire looks so",
                     name_of(sensor), rows.size(), view.rows(), rows.size() == 1 ? "s" : "", kSpikeSigmas,
                     view.t_s()[rows.front()])});
  }
}

/// One for the whole segment. Sensors without missing samples share their times: the first of them speaks for all.
void add_irregular_sampling(const View& view, std::vector<Finding>& findings) {
  bool judged_complete = false;
  for (const SensorSummary& summary : view.state.sensor) {
    if (!summary.sampling_judged || (summary.complete && judged_complete)) continue;
    judged_complete = summary.complete;
    if (!summary.irregular_sampling) continue;
    findings.push_back(*summary.irregular_sampling);
    return;
  }
}

// Steps of a thermometer.

/// A rounded temperature is off by up to half a step, √(1/12) of it in the mean square.
constexpr double kRoundingShare = 0.28867513459481287;

void judge_step(const View& view, double step_c, std::optional<Sensor> sensor, std::vector<Finding>& findings) {
  if (step_c < view.limits.coarse_step_c) return;
  const std::string whose = sensor ? fmt::format("the thermometer of {}", name_of(*sensor)) : "the unit's thermometer";
  findings.push_back(
      {"coarse_thermometer", Severity::warn, sensor,
       fmt::format("{} moves in steps of {:.2g} K (finer than {:.2g} K would be right): temperatures are off by {:.2g} "
                   "K (1 sigma), rates of change are false, and the curve is smeared by its slope times that",
                   whose, step_c, view.limits.coarse_step_c, kRoundingShare * step_c)});
}

}  // namespace

std::optional<Finding> saturated(const Samples& samples) {
  const std::span<const double> x = samples.present.values();
  if (x.empty()) return std::nullopt;
  const auto range = range_of(samples.view, samples.sensor);
  if (const std::size_t hits = range ? count_beyond(x, *range) : 0; hits > 0) {
    return saturation(samples, hits, "reach the range of", *range);
  }
  const std::vector<Extremes> parts = extremes_by_part(x);
  Extremes extremes = parts.front();
  for (const Extremes& part : parts) {
    extremes = {std::min(extremes.low, part.low), std::max(extremes.high, part.high)};
  }
  for (const double extreme : {extremes.low, extremes.high}) {
    if (const std::size_t hits = pinned_at(x, extreme, parts); hits > 0)
      return saturation(samples, hits, "are cut off at", extreme);
  }
  return std::nullopt;
}

std::optional<Finding> stuck(const Samples& samples) {
  const auto& [view, sensor, present] = samples;
  const std::span<const double> x = present.values();
  if (x.size() < static_cast<std::size_t>(view.limits.stuck_samples)) return std::nullopt;
  if (samples.facts().one_number) return one_number(view, sensor, x.front());
  if (ignores_gravity(view, sensor)) {
    return Finding{"stuck", Severity::reject, sensor,
                   fmt::format("{} gives {:.6g} {} all through this segment, as in another position, where gravity "
                               "along its axis is another",
                               name_of(sensor), x.front() * printed_per_si(sensor), printed_unit(sensor))};
  }
  const std::size_t shortest = shortest_stuck(view, sensor, x.size());
  if (shortest == 0) return std::nullopt;
  const Repeats runs = long_runs(x, shortest);
  if (runs.samples == 0) return std::nullopt;
  const double share = static_cast<double>(runs.samples) / static_cast<double>(x.size());
  return Finding{"stuck", share > view.limits.pinned_share ? Severity::reject : Severity::warn, sensor,
                 repeats_text(sensor, runs, x.size(), shortest)};
}

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
                 fmt::format("{}: {:.1f} % of the samples are missing, for up to {:.3g} s (one every {:.3g} s would be "
                             "right; more than {:.0f} % missing are not used)",
                             name_of(samples.sensor), 100.0 * loss.share, loss.longest_s, samples.facts().interval_s,
                             100.0 * limits.missing_reject_share)};
}

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
                 fmt::format("{:.0f} % of the intervals of {} differ from the usual {:.3g} s by more than half of it: "
                             "standard errors, spectra and wavelets take samples as equally spaced",
                             100.0 * share, name_of(samples.sensor), samples.facts().interval_s)};
}

void sensor_findings(const View& view, std::vector<Finding>& findings) {
  add_spikes(view, findings);
  add_each(view, &SensorSummary::saturated, findings);
  add_each(view, &SensorSummary::stuck, findings);
  add_each(view, &SensorSummary::dropouts, findings);
  add_irregular_sampling(view, findings);
}

void coarse_thermometer(const View& view, std::vector<Finding>& findings) {
  const double type_step_c = view.type.temp_lsb_c.value_or(0.0);
  judge_step(view, std::max(type_step_c, view.facts.temp_step_c), std::nullopt, findings);
  for (const Sensor sensor : kSensors) {
    judge_step(view, view.facts.sensor_temp_step_c[index_of(sensor)], sensor, findings);
  }
}

}  // namespace soak::calib::gate
