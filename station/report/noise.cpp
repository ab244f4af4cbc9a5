// SPDX-License-Identifier: Apache-2.0
#include "station/report/noise.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/signal/documents/signal_json.h"
#include "station/io/output.h"
#include "station/runs/signal_source.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// The Allan document of one sensor, or {"reason"} where there is none. Damage of the run file is a failure.
base::Result<json> sensor_noise(const db::Catalog& catalog, const StillSegment& still, calib::Sensor sensor) {
  const RunPart part{{.unit = still.run.unit, .campaign = still.run.campaign, .run = still.run.run_id},
                     still.segment.key.visit,
                     still.segment.key.position};
  auto record = read_run_signal(catalog, part, std::string(calib::name_of(sensor)));
  if (!record) {
    if (record.error().kind == base::ErrorKind::corrupt) return base::forward_error(record);
    return json{{"reason", record.error().message}};
  }
  if (record->values.size() > kMostNoiseSamples) {
    record->values.resize(kMostNoiseSamples);
    record->t_s.resize(kMostNoiseSamples);
  }
  const auto document = calib::allan_json(*record, {});
  return document ? *document : json{{"reason", document.error().message}};
}

json segment_json(const StillSegment& still) {
  const calib::Segment& segment = still.segment;
  return {{"run", still.run.label},
          {"campaign", still.run.campaign},
          {"content_sha256", still.run.content_sha256},
          {"simulated", still.run.simulated},
          {"visit", segment.key.visit},
          {"position", segment.key.position},
          {"plateau_c", number_or_null(segment.plateau_c)},
          {"temp_c", number_or_null(segment.temp_c)},
          {"duration_s", length_s(segment)}};
}

}  // namespace

base::Result<json> noise_json(const db::Catalog& catalog, const std::string& unit, std::int32_t epoch,
                              const std::function<bool(double)>& progress) {
  const auto longest = longest_still_segment(catalog, unit, epoch);
  if (!longest) return base::forward_error(longest);
  if (!*longest) {
    return json{{"segment", json()},
                {"sensors", json::object()},
                {"reason", "no run of the unit has a segment at rest that the data gate accepts"}};
  }
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    if (!progress(static_cast<double>(calib::index_of(sensor)) / calib::kSensorCount)) {
      return base::fail(base::ErrorKind::internal, "interrupted; no report was written");
    }
    if ((*longest)->segment.sensor[calib::index_of(sensor)].count == 0) continue;
    auto document = sensor_noise(catalog, **longest, sensor);
    if (!document) return base::forward_error(document);
    sensors[std::string(calib::name_of(sensor))] = *std::move(document);
  }
  return json{{"segment", segment_json(**longest)}, {"sensors", std::move(sensors)}, {"reason", json()}};
}

}  // namespace soak::station
