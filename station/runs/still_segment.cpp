// SPDX-License-Identifier: Apache-2.0
#include "station/runs/still_segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "calib/estimate/unit_input.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/runs/rest_record.h"
#include "station/runs/signal_source.h"

namespace soak::station {

double length_s(const calib::Segment& segment) { return segment.t_end_s - segment.t_start_s; }

base::Result<std::optional<StillSegment>> longest_still_segment(const db::Catalog& catalog, const std::string& unit,
                                                                std::int32_t epoch) {
  const auto runs = catalog.runs({.unit = unit, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  std::optional<StillSegment> longest;
  for (const db::RunRow& run : *runs) {
    if (!run.sealed || run.voided || run.samples_dropped || run.epoch != epoch) continue;
    const auto segments = catalog.segments(run.run_id, run.unit, false);
    if (!segments) return base::forward_error(segments);
    for (const calib::Segment& segment : *segments) {
      if (calib::is_rejected(segment) || turns(segment)) continue;
      if (!longest || length_s(segment) > length_s(longest->segment)) longest = StillSegment{run, segment};
    }
  }
  return longest;
}

base::Result<nlohmann::json> allan_at_rest(const db::Catalog& catalog, const StillSegment& still,
                                           calib::Sensor sensor) {
  const auto record = record_at_rest(catalog, still, sensor);
  if (!record) {
    if (record.error().kind == base::ErrorKind::corrupt) return base::forward_error(record);
    return nlohmann::json{{"reason", record.error().message}};
  }
  const auto document = calib::allan_json(*record, {});
  return document ? *document : nlohmann::json{{"reason", document.error().message}};
}

namespace {

/// The unit's longest segment at rest, which must be long enough.
base::Result<StillSegment> long_still_segment(const db::Catalog& catalog, const db::UnitRow& unit) {
  auto longest = longest_still_segment(catalog, unit.serial, unit.epoch);
  if (!longest) return base::forward_error(longest);
  const double seconds = *longest ? length_s((*longest)->segment) : 0.0;
  if (seconds >= calib::kKalibrLeastStill_s * 0.99) return **std::move(longest);
  return base::bad_input(fmt::format(
      "the longest segment at rest of unit {} lasts {:.0f} s; noise density and random walk need at least {:g} "
      "minutes, better hours, in one position at a constant temperature: record procedures/static-allan.toml",
      unit.serial, seconds, calib::kKalibrLeastStill_s / 60.0));
}

/// Least and greatest of the means over the segment's minutes.
base::Result<std::array<double, 2>> temperatures_of(const db::Catalog& catalog, const StillSegment& still) {
  const auto segments = catalog.segments(still.run.run_id, still.run.unit, true);
  if (!segments) return base::forward_error(segments);
  std::array<double, 2> range = {still.segment.temp_c, still.segment.temp_c};
  for (const calib::Segment& segment : *segments) {
    if (segment.key != still.segment.key) continue;
    for (const calib::Block& block : segment.blocks) {
      range = {std::min(range[0], block.temp_c), std::max(range[1], block.temp_c)};
    }
  }
  return range;
}

calib::KalibrSource kalibr_source(const StillSegment& still, const std::array<double, 2>& range_c,
                                  const db::UnitRow& unit) {
  return {.unit = unit.serial,
          .unit_type = unit.type,
          .run = still.run.label,
          .content_sha256 = still.run.content_sha256,
          .position = still.segment.key.position,
          .temp_c = still.segment.temp_c,
          .least_temp_c = range_c[0],
          .most_temp_c = range_c[1],
          .recorded_utc_s = still.run.created_utc_s,
          .created_utc_s = now_utc_s(),
          .simulated = still.run.simulated};
}

}  // namespace

base::Result<UnitNoise> unit_noise(const db::Catalog& catalog, const std::string& serial, bool simulated) {
  const auto unit = find_unit(catalog, serial);
  if (!unit) return base::forward_error(unit);
  const auto still = long_still_segment(catalog, *unit);
  if (!still) return base::forward_error(still);
  if (still->run.simulated && !simulated) {
    return base::bad_input(fmt::format("run {} of unit {} is SIMULATED; use --simulated to export its noise anyway",
                                       still->run.label, serial));
  }
  const auto range_c = temperatures_of(catalog, *still);
  if (!range_c) return base::forward_error(range_c);
  UnitNoise noise{kalibr_source(*still, *range_c, *unit), {}};
  const RunPart part{{.unit = serial, .campaign = still->run.campaign, .run = still->run.run_id},
                     still->segment.key.visit,
                     still->segment.key.position};
  for (const calib::Sensor sensor : calib::kSensors) {
    if (still->segment.sensor[calib::index_of(sensor)].count == 0) continue;
    const auto record = read_run_signal(catalog, part, std::string(calib::name_of(sensor)));
    if (!record) return base::forward_error(record);
    const auto axis = calib::axis_noise(sensor, *record);
    if (!axis) return base::forward_error(axis);
    noise.axes.push_back(*axis);
  }
  return noise;
}

}  // namespace soak::station
