// SPDX-License-Identifier: Apache-2.0
#include "calib/data_gate.h"

#include <fmt/format.h>

#include <algorithm>

#include "calib/gate/checks.h"

namespace soak::calib {
namespace {

/// "visit 3, +X", with the attempt where it is not the first.
std::string place_of(const SegmentKey& key) {
  std::string place = fmt::format("visit {}", key.visit);
  if (!key.position.empty()) place += ", " + key.position;
  if (key.attempt > 0) place += fmt::format(", attempt {}", key.attempt);
  return place;
}

/// A code with its severity, the segments that have it, and where it came first.
struct Tally {
  const Finding* finding;
  const Segment* first;
  const Segment* last;
  std::size_t segments = 1;
};

void count(std::vector<Tally>& tallies, const Segment& segment, const Finding& finding) {
  const auto same = std::find_if(tallies.begin(), tallies.end(), [&](const Tally& tally) {
    return tally.finding->code == finding.code && tally.finding->severity == finding.severity;
  });
  if (same == tallies.end()) {
    tallies.push_back({&finding, &segment, &segment});
    return;
  }
  if (same->last != &segment) ++same->segments;
  same->last = &segment;
}

void withdraw(Segment& segment, Sensor sensor) {
  segment.sensor[index_of(sensor)] = {};
  for (Block& block : segment.blocks) block.sensor[index_of(sensor)] = {};
}

}  // namespace

std::vector<std::vector<Finding>> examine(const Recording& recording, std::span<const Segment> segments,
                                          const UnitType& type, const GateLimits& limits) {
  const gate::Facts facts = gate::collect_facts(recording, segments, type);
  std::vector<std::vector<Finding>> findings;
  for (const Segment& segment : segments) {
    const auto [first, last] = gate::rows_of(recording, segment);
    gate::View view{recording, segments, segment, type, limits, facts, first, last};
    gate::prepare(view);
    auto& found = findings.emplace_back();
    for (const gate::Check check : gate::kChecks) check(view, found);
  }
  return findings;
}

bool is_rejected(const Segment& segment) {
  return std::any_of(segment.findings.begin(), segment.findings.end(),
                     [](const Finding& finding) { return finding.severity == Severity::reject && !finding.sensor; });
}

bool is_rejected(const Segment& segment, Sensor sensor) {
  return std::any_of(segment.findings.begin(), segment.findings.end(), [&](const Finding& finding) {
    return finding.severity == Severity::reject && finding.sensor.value_or(sensor) == sensor;
  });
}

std::vector<Segment> accepted(std::span<const Segment> segments) {
  std::vector<Segment> kept;
  for (const Segment& segment : segments) {
    if (is_rejected(segment)) continue;
    Segment& copy = kept.emplace_back(segment);
    for (const Sensor sensor : kSensors) {
      if (is_rejected(segment, sensor)) withdraw(copy, sensor);
    }
  }
  return kept;
}

std::vector<Warning> summarise(std::span<const Segment> segments) {
  std::vector<Tally> tallies;
  for (const Segment& segment : segments) {
    for (const Finding& finding : segment.findings) count(tallies, segment, finding);
  }
  std::vector<Warning> warnings;
  for (const Tally& tally : tallies) {
    const bool rejects = tally.finding->severity == Severity::reject;
    const std::string what = !rejects ? "has" : tally.finding->sensor ? "loses a sensor in" : "loses";
    warnings.push_back(
        {tally.finding->code, fmt::format("{} {} of {} segments; the first, {}: {}", what, tally.segments,
                                          segments.size(), place_of(tally.first->key), tally.finding->text)});
  }
  return warnings;
}

}  // namespace soak::calib
