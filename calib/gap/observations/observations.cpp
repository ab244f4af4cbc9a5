// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/observations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "calib/estimate/site.h"

namespace soak::calib::gap {
namespace {

constexpr double kSameLevel_c = 2.0;  ///< set points (or means) closer than that are one level

bool usable(const Segment& segment) {
  if (segment.phase != Phase::soak || !segment.plateau_c || segment.blocks.empty()) return false;
  if (segment.position && segment.position->rate_dps.value_or(0.0) != 0.0) return false;
  return std::none_of(segment.findings.begin(), segment.findings.end(),
                      [](const Finding& finding) { return finding.severity == Severity::reject && !finding.sensor; });
}

/// Distinct set points, rising.
std::vector<double> set_points(const LoggedCampaign& campaign) {
  std::vector<double> all;
  for (const LoggedRun& run : campaign.runs) {
    for (const Segment& segment : run.run.segments) {
      if (usable(segment)) all.push_back(*segment.plateau_c);
    }
  }
  std::sort(all.begin(), all.end());
  std::vector<double> distinct;
  for (const double c : all) {
    if (distinct.empty() || c - distinct.back() > kSameLevel_c) distinct.push_back(c);
  }
  return distinct;
}

int nearest(const std::vector<double>& levels, double temp_c) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < levels.size(); ++k) {
    if (std::abs(levels[k] - temp_c) < std::abs(levels[best] - temp_c)) best = k;
  }
  return static_cast<int>(best);
}

class Collector {
 public:
  explicit Collector(const LoggedCampaign& campaign) : levels_(set_points(campaign)) {
    rows_.sign_at_rest = campaign.type.sign_at_rest;
  }

  void add(const LoggedRun& run, std::size_t number) {
    std::vector<const Segment*> segments;
    for (const Segment& segment : run.run.segments) {
      if (usable(segment)) segments.push_back(&segment);
    }
    if (segments.empty()) return;
    const int index = rows_.run_count();
    rows_.runs.push_back(run.run.label);
    rows_.run_ids.push_back(run.run.run_id);
    rows_.logged.push_back(number);
    earth_ = place_of(run.run.segments, run.run.site).earth;
    rows_.earth_taken_off = rows_.earth_taken_off || earth_.vertical_rps != 0.0;
    std::sort(segments.begin(), segments.end(),
              [](const Segment* a, const Segment* b) { return a->t_start_s < b->t_start_s; });
    occurrences_.clear();
    int last_visit = -1;
    int order = 0;
    int previous = -1;
    for (const Segment* segment : segments) {
      order = segment->key.visit == last_visit ? order + 1 : 0;
      if (segment->key.visit != last_visit) ++occurrences_[{nearest(levels_, *segment->plateau_c), segment->sweep}];
      last_visit = segment->key.visit;
      previous = add(*segment, run, index, order, previous);
    }
  }

  Observations finish() {
    rows_.level_c.assign(levels_.size(), 0.0);
    std::vector<double> count(levels_.size(), 0.0);
    for (const Observation& row : rows_.rows) {
      const auto k = static_cast<std::size_t>(row.level);
      count[k] += 1.0;
      rows_.level_c[k] += (row.temp_c - rows_.level_c[k]) / count[k];
    }
    return std::move(rows_);
  }

 private:
  int position_of(const Segment& segment) {
    if (!segment.position) return -1;
    const auto found = std::find_if(rows_.positions.begin(), rows_.positions.end(),
                                    [&](const Position& p) { return p == *segment.position; });
    if (found != rows_.positions.end()) return static_cast<int>(found - rows_.positions.begin());
    rows_.positions.push_back(*segment.position);
    return static_cast<int>(rows_.positions.size()) - 1;
  }

  int add(const Segment& segment, const LoggedRun& run, int index, int order, int previous) {
    Observation row;
    row.run = index;
    row.visit = segment.key.visit;
    row.placement = placements_++;
    row.order = order;
    row.previous = previous;
    row.level = nearest(levels_, *segment.plateau_c);
    row.sweep = segment.sweep;
    row.position = position_of(segment);
    const int occurrence = occurrences_[{row.level, row.sweep}];
    row.cell = cells_.try_emplace({row.level, row.sweep, occurrence, row.position}, static_cast<int>(cells_.size()))
                   .first->second;
    if (segment.position) row.up = segment.position->up;
    const Gravity gravity = gravity_at(run.run.site);
    rows_.gravity_mps2 = gravity.mps2;
    const Vector3 earth_rps = rotation_of_the_earth(segment, run.run.site);
    for (const Block& block : segment.blocks) {
      row.t_s = block.t_s;
      row.t_in_placement_s = block.t_s - segment.t_start_s;
      row.temp_c = block.temp_c;
      row.sensor_temp_c = block.sensor_temp_c;
      row.sensor = block.sensor;
      for (std::size_t axis = 0; axis < 3; ++axis) row.sensor[axis].mean -= earth_rps[axis];
      reject(segment, row);
      rows_.rows.push_back(row);
      ++row.block;
    }
    return row.position;
  }

  /// What is known of it, along the body axes.
  [[nodiscard]] Vector3 rotation_of_the_earth(const Segment& segment, const Site& site) const {
    Vector3 rate{};
    if (!segment.position) return rate;
    const Frame frame = frame_of(*segment.position, site.azimuth_deg.value_or(0.0));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rate[axis] = earth_.vertical_rps * frame.up[axis] + earth_.horizontal_rps * frame.north[axis];
    }
    return rate;
  }

  static void reject(const Segment& segment, Observation& row) {
    for (const Finding& finding : segment.findings) {
      if (finding.severity == Severity::reject && finding.sensor) row.sensor[index_of(*finding.sensor)].count = 0;
    }
  }

  std::vector<double> levels_;
  Observations rows_;
  EarthRate earth_;
  int placements_ = 0;
  std::map<std::pair<int, Sweep>, int> occurrences_;
  std::map<std::tuple<int, Sweep, int, int>, int> cells_;
};

}  // namespace

Observations observe(const LoggedCampaign& campaign) {
  Collector collector(campaign);
  for (std::size_t r = 0; r < campaign.runs.size(); ++r) collector.add(campaign.runs[r], r);
  return collector.finish();
}

}  // namespace soak::calib::gap
