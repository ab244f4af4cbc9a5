// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/unit_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

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
struct KeptRun {
  RunInput run;
  std::vector<std::string> copies;
};

Warning copies_warning(const KeptRun& kept) {
  return {"copied_runs",
          fmt::format("run {} holds the same samples as {}: they count once, by the first; void what is a copy ('soak "
                      "runs void')",
                      fmt::join(kept.copies, ", "), run_name(kept.run))};
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
  std::vector<KeptRun> all;
  for (RunInput& run : runs) {
    const auto first =
        std::find_if(all.begin(), all.end(), [&](const KeptRun& kept) { return is_copy(run, kept.run); });
    if (first != all.end()) {
      first->copies.push_back(run_name(run));
    } else {
      all.push_back({std::move(run), {}});
    }
  }
  runs.clear();
  for (KeptRun& kept : all) {
    if (!kept.copies.empty()) warnings.push_back(copies_warning(kept));
    runs.push_back(std::move(kept.run));
  }
}

}  // namespace soak::calib
