// SPDX-License-Identifier: Apache-2.0
#include "station/runs/rest_record.h"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "station/io/output.h"
#include "station/runs/signal_source.h"

namespace soak::station {

nlohmann::json still_segment_json(const StillSegment& still) {
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

base::Result<calib::SignalRecord> record_at_rest(const db::Catalog& catalog, const StillSegment& still,
                                                 calib::Sensor sensor) {
  constexpr std::size_t kMostSamples = std::size_t{1} << 22U;
  const RunPart part{{.unit = still.run.unit, .campaign = still.run.campaign, .run = still.run.run_id},
                     still.segment.key.visit,
                     still.segment.key.position,
                     still.segment.key.attempt,
                     kMostSamples};
  auto record = read_run_signal(catalog, part, std::string(calib::name_of(sensor)));
  if (record && record->values.size() > kMostSamples) {
    record->values.resize(kMostSamples);
    record->t_s.resize(kMostSamples);
  }
  return record;
}

}  // namespace soak::station
