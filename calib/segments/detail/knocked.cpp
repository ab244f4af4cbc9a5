// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

/// A knock that shifts a mean by more standard errors of its noise than this spoils the segment.
constexpr double kTolerableShift = 3.0;

/// Knocks of a segment: bursts of hits in several sensors.
struct Knocks {
  int count = 0;
  double first_s = 0.0;
  std::vector<std::size_t> rows;
};

/// Rows that are hit in any sensor, rising.
std::vector<std::size_t> rows_hit(const View& view) {
  std::vector<std::size_t> rows;
  for (const SensorSummary& summary : view.state.sensor) {
    for (const Hit& hit : summary.levels.hits) rows.push_back(hit.row);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

/// Rows from `first` on whose hits follow each other within kBurstGap_s or from row to row.
std::vector<std::size_t> burst_from(const View& view, const std::vector<std::size_t>& hits, std::size_t first) {
  const double near_s =
      std::max(kBurstGap_s, 1.5 * (view.t_s().back() - view.t_s().front()) / static_cast<double>(view.rows()));
  std::vector<std::size_t> burst = {hits[first]};
  for (std::size_t i = first + 1; i < hits.size() && view.t_s()[hits[i]] - view.t_s()[burst.back()] <= near_s; ++i) {
    burst.push_back(hits[i]);
  }
  return burst;
}

int sensors_hit(const View& view, const std::vector<std::size_t>& burst) {
  const auto& sensors = view.state.sensor;
  return static_cast<int>(std::count_if(sensors.begin(), sensors.end(), [&](const SensorSummary& summary) {
    const Levels& levels = summary.levels;
    const auto hit = std::lower_bound(levels.hits.begin(), levels.hits.end(), burst.front(),
                                      [](const Hit& h, std::size_t row) { return h.row < row; });
    return hit != levels.hits.end() && hit->row <= burst.back();
  }));
}

Knocks find_knocks(const View& view) {
  const std::vector<std::size_t> hits = rows_hit(view);
  Knocks knocks;
  for (std::size_t first = 0; first < hits.size();) {
    const std::vector<std::size_t> burst = burst_from(view, hits, first);
    first += burst.size();
    if (sensors_hit(view, burst) < view.limits.knock_sensors) continue;
    if (knocks.count++ == 0) knocks.first_s = view.t_s()[burst.front()];
    knocks.rows.insert(knocks.rows.end(), burst.begin(), burst.end());
  }
  return knocks;
}

/// Largest shift of a sensor's mean by its hits among `rows`, in standard errors of its white noise: Σ r / (σ √n).
double shift_of(const View& view, const std::vector<std::size_t>& rows) {
  double largest = 0.0;
  for (const Sensor sensor : kSensors) {
    const Levels& levels = view.levels_of(sensor);
    double sum = 0.0;
    for (const Hit& hit : levels.hits) {
      if (std::binary_search(rows.begin(), rows.end(), hit.row)) sum += hit.residual;
    }
    const auto samples = static_cast<double>(view.summary_of(sensor).samples);
    if (sum != 0.0) largest = std::max(largest, std::abs(sum) / (levels.sigma * std::sqrt(samples)));
  }
  return largest;
}

}  // namespace

void knocked(const View& view, std::vector<Finding>& findings) {
  if (rejected_as(findings, "moved")) return;
  const Knocks knocks = find_knocks(view);
  if (knocks.count == 0) return;
  const double shift = shift_of(view, knocks.rows);
  findings.push_back({"knocked", shift > kTolerableShift ? Severity::reject : Severity::warn, std::nullopt,
                      fmt::format("{} burst{} beyond {:.0f} sigma in several sensors at once, the first at {:.2f} s, "
                                  "shift a mean by {:.1f} standard errors of its noise (up to {:.0f} are tolerable)",
                                  knocks.count, knocks.count == 1 ? "" : "s", view.limits.knock_sigmas, knocks.first_s,
                                  shift, kTolerableShift)});
}

}  // namespace soak::calib::gate
