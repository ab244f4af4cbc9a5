// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/gate/checks.h"

namespace soak::calib::gate {
namespace {

/// Noise in output steps from which chance bounds the length of runs; quieter sensors stand on one step for long.
constexpr double kLoudNoise = 1.0;
/// Runs longer than this many usual ones (a device that repeats its values has long usual ones).
constexpr double kUsualRuns = 5.0;

/// Output step: as the type states, else the smallest difference seen.
double step_of(const View& view, Sensor sensor) {
  const double stated = is_gyro(sensor) ? view.type.gyro_lsb_dps.value_or(0.0) / printed_per_si(sensor)
                                        : view.type.accel_lsb_mps2.value_or(0.0);
  return std::max(stated, view.facts_of(sensor).step);
}

/// Shortest run that counts as stuck; 0 = the resolution cannot tell.
///
/// With white noise σ rounded to steps q, a sample repeats the one before with a chance of at most p = erf(q/(2√2 σ)),
/// that of the step in the middle. A run of L among N samples has a chance of N·p^(L−1) at most.
std::size_t shortest_stuck(const View& view, Sensor sensor, std::size_t samples) {
  const SensorFacts& facts = view.facts_of(sensor);
  const double step = step_of(view, sensor);
  if (step <= 0.0 || facts.noise < kLoudNoise * step) return 0;
  const double repeat = std::erf(step / (2.0 * std::numbers::sqrt2 * facts.noise));
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

Runs long_runs(const std::vector<double>& x, std::size_t shortest) {
  Runs runs;
  for (std::size_t first = 0; first < x.size();) {
    std::size_t last = first;
    while (last < x.size() && x[last] == x[first]) ++last;
    const std::size_t length = last - first;
    if (length >= shortest) runs.samples += length;
    if (length > runs.longest) {
      runs.longest = length;
      runs.value = x[first];
    }
    first = last;
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
  const bool certain = view.facts.circumstances_differ;
  return {"stuck", certain ? Severity::reject : Severity::warn, sensor,
          fmt::format("{} gives {:.6g} {} throughout the recording: {}", name_of(sensor),
                      value * printed_per_si(sensor), printed_unit(sensor),
                      certain ? "a live sensor would differ between positions and temperatures"
                              : "a live sensor has noise, if its resolution shows it")};
}

void judge(const View& view, Sensor sensor, const std::vector<double>& x, std::vector<Finding>& findings) {
  if (view.facts_of(sensor).one_number) {
    findings.push_back(throughout(view, sensor, x.front()));
    return;
  }
  const std::size_t shortest = shortest_stuck(view, sensor, x.size());
  if (shortest == 0) return;
  const Runs runs = long_runs(x, shortest);
  if (runs.samples == 0) return;
  const double share = static_cast<double>(runs.samples) / static_cast<double>(x.size());
  findings.push_back({"stuck", share > view.limits.pinned_share ? Severity::reject : Severity::warn, sensor,
                      text_of(sensor, runs, x.size(), shortest)});
}

}  // namespace

void stuck(const View& view, std::vector<Finding>& findings) {
  for (const Sensor sensor : kSensors) {
    const std::vector<double> x = present(view.values(sensor));
    if (x.size() < static_cast<std::size_t>(view.limits.stuck_samples) || has(findings, "saturated", sensor)) continue;
    judge(view, sensor, x, findings);
  }
}

}  // namespace soak::calib::gate
