// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/observations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "calib/estimate/site.h"
#include "calib/segments/data_gate.h"

namespace soak::calib::gap {
namespace {

constexpr double kSameLevel_c = 2.0;  ///< set points (or means) closer than that are one level

/// Segments of a run that count, in the order of time, without the sensors that the data gate rejected.
std::vector<Segment> observed_segments(const LoggedRun& run) {
  std::vector<Segment> segments = accepted(run.run.segments);
  std::erase_if(segments, [](const Segment& segment) { return !is_observed(segment) || segment.blocks.empty(); });
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.t_start_s < b.t_start_s; });
  return segments;
}

/// Distinct set points, rising.
std::vector<double> distinct_set_points(const std::vector<std::vector<Segment>>& runs) {
  std::vector<double> all;
  for (const auto& segments : runs) {
    for (const Segment& segment : segments) all.push_back(*segment.plateau_c);
  }
  std::sort(all.begin(), all.end());
  std::vector<double> distinct;
  for (const double c : all) {
    if (distinct.empty() || c - distinct.back() > kSameLevel_c) distinct.push_back(c);
  }
  return distinct;
}

/// What is known of the Earth's rotation in a segment, along the body axes.
Vector3 earth_rotation_rps(const Segment& segment, const Site& site, const EarthRate& earth) {
  Vector3 rate{};
  if (!segment.position) return rate;
  const Frame frame = frame_of(*segment.position, site.azimuth_deg.value_or(0.0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rate[axis] = earth.vertical_rps * frame.up[axis] + earth.horizontal_rps * frame.north[axis];
  }
  return rate;
}

/// Numbers placements, positions and cells while the rows are collected.
class Collector {
 public:
  Collector(const LoggedCampaign& campaign, const std::vector<double>& set_points) : set_points_(set_points) {
    result_.sign_at_rest = campaign.type.sign_at_rest;
  }

  void add_run(const LoggedRun& run, std::size_t number, const std::vector<Segment>& segments) {
    if (segments.empty()) return;
    const EarthRate earth = place_of(run.run.segments, run.run.site).earth;
    Observation row;
    row.run = result_.run_count();
    row.visit = -1;
    result_.runs.push_back(run.run.label);
    result_.run_ids.push_back(run.run.run_id);
    result_.logged.push_back(number);
    result_.gravity_mps2 = gravity_at(run.run.site).mps2;
    result_.earth_taken_off = result_.earth_taken_off || earth.vertical_rps != 0.0;
    occurrences_.clear();
    for (const Segment& segment : segments) {
      const bool same_visit = segment.key.visit == row.visit;
      row.previous = row.position;
      row.visit = segment.key.visit;
      row.order = same_visit ? row.order + 1 : 0;
      row.placement = placements_++;
      row.level = static_cast<int>(nearest_level(set_points_, *segment.plateau_c));
      row.sweep = segment.sweep;
      row.position = position_of(segment);
      row.up = segment.position ? segment.position->up : Vector3{};
      int& occurrence = occurrences_[{row.level, row.sweep}];
      if (!same_visit) ++occurrence;
      row.cell = cells_.try_emplace({row.level, row.sweep, occurrence, row.position}, static_cast<int>(cells_.size()))
                     .first->second;
      add_blocks(segment, earth_rotation_rps(segment, run.run.site, earth), row);
    }
  }

  /// The level at each set point is the mean of its rows.
  Observations finish() {
    result_.level_c.assign(set_points_.size(), 0.0);
    std::vector<double> count(set_points_.size(), 0.0);
    for (const Observation& row : result_.rows) {
      const auto k = static_cast<std::size_t>(row.level);
      count[k] += 1.0;
      result_.level_c[k] += (row.temp_c - result_.level_c[k]) / count[k];
    }
    return std::move(result_);
  }

 private:
  int position_of(const Segment& segment) {
    if (!segment.position) return -1;
    const auto found = std::find(result_.positions.begin(), result_.positions.end(), *segment.position);
    const auto index = static_cast<int>(found - result_.positions.begin());
    if (found == result_.positions.end()) result_.positions.push_back(*segment.position);
    return index;
  }

  void add_blocks(const Segment& segment, const Vector3& earth_rps, Observation& row) {
    row.block = 0;
    for (const Block& block : segment.blocks) {
      row.t_s = block.t_s;
      row.t_in_placement_s = block.t_s - segment.t_start_s;
      row.temp_c = block.temp_c;
      row.sensor_temp_c = block.sensor_temp_c;
      row.sensor = block.sensor;
      for (std::size_t axis = 0; axis < 3; ++axis) row.sensor[axis].mean -= earth_rps[axis];
      result_.rows.push_back(row);
      ++row.block;
    }
  }

  const std::vector<double>& set_points_;
  Observations result_;
  int placements_ = 0;
  std::map<std::pair<int, Sweep>, int> occurrences_;
  std::map<std::tuple<int, Sweep, int, int>, int> cells_;
};

/// The first finding by which the gate rejects a sensor in a segment, or the whole segment; null where there is none.
const Finding* rejecting_finding(const Segment& segment, std::optional<Sensor> sensor) {
  const auto found = std::find_if(segment.findings.begin(), segment.findings.end(), [&](const Finding& finding) {
    return finding.severity == Severity::reject && finding.sensor == sensor;
  });
  return found == segment.findings.end() ? nullptr : &*found;
}

}  // namespace

std::string list_of(const std::vector<Sensor>& sensors) {
  std::vector<std::string_view> names;
  for (const Sensor sensor : sensors) names.push_back(name_of(sensor));
  return fmt::format("{}", fmt::join(names, ", "));
}

bool is_observed(const Segment& segment) {
  return segment.phase == Phase::soak && segment.plateau_c && !turns(segment) && !is_rejected(segment);
}

std::size_t nearest_level(const std::vector<double>& level_c, double temp_c) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < level_c.size(); ++k) {
    if (std::abs(level_c[k] - temp_c) < std::abs(level_c[best] - temp_c)) best = k;
  }
  return best;
}

Observations observe(const LoggedCampaign& campaign) {
  std::vector<std::vector<Segment>> segments;
  for (const LoggedRun& run : campaign.runs) segments.push_back(observed_segments(run));
  const std::vector<double> set_points = distinct_set_points(segments);
  Collector collector(campaign, set_points);
  for (std::size_t r = 0; r < segments.size(); ++r) collector.add_run(campaign.runs[r], r, segments[r]);
  return collector.finish();
}

std::vector<GateRejection> rejected_by_gate(const LoggedCampaign& campaign) {
  std::vector<GateRejection> all;
  std::vector<std::optional<Sensor>> scopes = {std::nullopt};
  scopes.insert(scopes.end(), kSensors.begin(), kSensors.end());
  // A recording of ramps is no part of a search at plateaus.
  const bool with_plateaus = has_plateaus(campaign);
  for (const LoggedRun& run : campaign.runs) {
    for (const auto& sensor : scopes) {
      GateRejection entry{.run = run.run.label, .sensor = sensor, .segments = 0, .of = 0, .code = {}, .why = {}};
      for (const Segment& segment : run.run.segments) {
        if (with_plateaus && !(segment.phase == Phase::soak && segment.plateau_c)) continue;
        ++entry.of;
        const Finding* finding = sensor && is_rejected(segment) ? nullptr : rejecting_finding(segment, sensor);
        if (finding == nullptr || entry.segments++ > 0) continue;
        entry.code = finding->code;
        entry.why = finding->text;
      }
      if (entry.segments > 0) all.push_back(std::move(entry));
    }
  }
  return all;
}

std::string in_words(const std::vector<GateRejection>& rejections) {
  constexpr std::size_t kMostInWords = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostInWords, rejections.size()); ++i) {
    const GateRejection& entry = rejections[i];
    text += fmt::format("{}{}run {} in {} of {} segments ({})", text.empty() ? "" : ", ",
                        entry.sensor ? fmt::format("{} of ", name_of(*entry.sensor)) : "", entry.run, entry.segments,
                        entry.of, entry.code);
  }
  if (rejections.size() > kMostInWords) text += fmt::format(" and {} more", rejections.size() - kMostInWords);
  return text;
}

bool mostly_rejected_run(const std::vector<GateRejection>& rejections) {
  return std::any_of(rejections.begin(), rejections.end(),
                     [](const GateRejection& entry) { return !entry.sensor && 2 * entry.segments > entry.of; });
}

}  // namespace soak::calib::gap
