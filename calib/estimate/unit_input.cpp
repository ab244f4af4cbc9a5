// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/unit_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "calib/estimate/certificates.h"

namespace soak::calib {
namespace {

bool same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool same_statistics(const SensorStatistics& a, const SensorStatistics& b) {
  if (a.count != b.count) return false;
  return a.count == 0 || (same_number(a.mean, b.mean) && same_number(a.variance, b.variance));
}

bool same_numbers(const Segment& a, const Segment& b) {
  return same_number(a.temp_c, b.temp_c) &&
         std::equal(a.sensor.begin(), a.sensor.end(), b.sensor.begin(), same_statistics);
}

/// A sensor that repeats one number tells no recording from another.
bool scatters(const Segment& segment) {
  return std::any_of(segment.sensor.begin(), segment.sensor.end(),
                     [](const SensorStatistics& sensor) { return sensor.count > 1 && sensor.variance > 0.0; });
}

bool is_copy(const RunInput& run, const RunInput& of) {
  if (!run.content_sha256.empty() && run.content_sha256 == of.content_sha256) return true;
  return same_samples(run.segments, of.segments);
}

std::string run_name(const RunInput& run) { return fmt::format("{}/{}", run.campaign, run.label); }

/// A run that stays, and the names of its copies.
struct Original {
  RunInput run;
  std::vector<std::string> copies;
};

Warning copies_warning(const Original& original) {
  return {"copied_runs",
          fmt::format("run {} holds the same samples as {}: the fit uses them once; void the copies ('soak runs void')",
                      fmt::join(original.copies, ", "), run_name(original.run))};
}

// Findings of the data gate.

/// "visit 3, +X", with the attempt where it is not the first.
std::string visit_text(const SegmentKey& key) {
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

void count_finding(std::vector<Tally>& tallies, const Segment& segment, const Finding& finding) {
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

/// A warning of one run, and in how many more it occurs.
struct GateWarning {
  Warning warning;
  std::size_t more_runs = 0;
};

void add_gate_warnings(const RunInput& run, std::vector<GateWarning>& all) {
  std::set<std::string> counted;
  for (const Warning& warning : gate_warnings(run.segments)) {
    const auto same = std::ranges::find_if(all, [&](const GateWarning& w) { return w.warning.code == warning.code; });
    if (same == all.end() || counted.contains(warning.code)) {
      all.push_back({{warning.code, fmt::format("run {}: {} {}", run.label, warning.code, warning.text)}});
    } else {
      ++same->more_runs;
    }
    counted.insert(warning.code);
  }
}

}  // namespace

std::array<bool, kSensorCount> own_thermometers(const std::vector<Segment>& segments) {
  std::array<bool, kSensorCount> own{};
  for (const Segment& segment : segments) {
    for (std::size_t s = 0; s < kSensorCount; ++s) {
      // Without one the unit's mean stands there, the very same number (segmentation.cpp).
      own[s] = own[s] || (segment.sensor[s].count > 0 && segment.sensor_temp_c[s] != segment.temp_c);
    }
  }
  return own;
}

bool same_samples(std::span<const Segment> a, std::span<const Segment> b) {
  bool told = false;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].t_start_s != b[j].t_start_s) {
      a[i].t_start_s < b[j].t_start_s ? ++i : ++j;
      continue;
    }
    if (a[i].t_end_s == b[j].t_end_s) {
      if (!same_numbers(a[i], b[j])) return false;
      told = told || scatters(a[i]);
    }
    ++i;
    ++j;
  }
  return told;
}

void leave_out_copies(std::vector<RunInput>& runs, std::vector<Warning>& warnings) {
  std::vector<Original> originals;
  for (RunInput& run : runs) {
    const auto same =
        std::ranges::find_if(originals, [&](const Original& original) { return is_copy(run, original.run); });
    if (same != originals.end()) {
      same->copies.push_back(run_name(run));
    } else {
      originals.push_back({std::move(run), {}});
    }
  }
  runs.clear();
  for (Original& original : originals) {
    if (!original.copies.empty()) warnings.push_back(copies_warning(original));
    runs.push_back(std::move(original.run));
  }
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
    kept.push_back(segment);
    for (const Sensor sensor : kSensors) {
      if (is_rejected(segment, sensor)) withdraw(kept.back(), sensor);
    }
  }
  return kept;
}

std::vector<Warning> gate_warnings(std::span<const Segment> segments) {
  std::vector<Tally> tallies;
  for (const Segment& segment : segments) {
    for (const Finding& finding : segment.findings) count_finding(tallies, segment, finding);
  }
  std::vector<Warning> warnings;
  for (const Tally& tally : tallies) {
    const bool rejects = tally.finding->severity == Severity::reject;
    const std::string what = !rejects ? "found in" : tally.finding->sensor ? "rejects a sensor in" : "rejects";
    warnings.push_back(
        {tally.finding->code, fmt::format("{} {} of {} segments; the first, {}: {}", what, tally.segments,
                                          segments.size(), visit_text(tally.first->key), tally.finding->text)});
  }
  return warnings;
}

std::string more_runs_text(std::size_t more) {
  return more == 0 ? "" : fmt::format(" (also in {} more run{})", more, more == 1 ? "" : "s");
}

std::vector<GatedRun> gate_runs(const UnitInput& input, std::vector<Warning>& warnings) {
  std::vector<GateWarning> all;
  std::vector<GatedRun> used;
  for (const RunInput& run : input.runs) {
    add_gate_warnings(run, all);
    std::vector<Segment> kept = accepted(run.segments);
    correct_rates(kept, input.references, run.campaign);
    const Place place = place_of(kept, with_reference_gravity(run.site, input.references));
    used.push_back({&run, std::move(kept), place});
  }
  for (GateWarning& one : all) {
    one.warning.text += more_runs_text(one.more_runs);
    warnings.push_back(std::move(one.warning));
  }
  return used;
}

}  // namespace soak::calib
