// SPDX-License-Identifier: Apache-2.0
#include "station/commands/export_noise.h"

#include <fmt/format.h>

#include <optional>

#include "station/io/host.h"
#include "station/runs/signal_source.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

base::Result<StillSegment> still_segment(const db::Catalog& catalog, const std::string& serial) {
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (!*unit) {
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", serial));
  }
  auto longest = longest_still_segment(catalog, serial, (*unit)->epoch);
  if (!longest) return base::forward_error(longest);
  const double seconds = *longest ? length_s((*longest)->segment) : 0.0;
  if (seconds >= calib::kKalibrLeastStill_s * 0.99) return **std::move(longest);
  return base::bad_input(fmt::format(
      "the longest segment at rest of unit {} lasts {:.0f} s; noise density and random walk need {:g} minutes, better "
      "hours, in one position at a constant temperature: record procedures/static-allan.toml",
      serial, seconds, calib::kKalibrLeastStill_s / 60.0));
}

calib::KalibrSource source_of(const StillSegment& still, const db::UnitRow& unit) {
  return {.unit = unit.serial,
          .unit_type = unit.type,
          .run = still.run.label,
          .content_sha256 = still.run.content_sha256,
          .position = still.segment.key.position,
          .temp_c = still.segment.temp_c,
          .recorded_utc_s = still.run.created_utc_s,
          .created_utc_s = now_utc_s(),
          .simulated = still.run.simulated};
}

}  // namespace

base::Result<UnitNoise> unit_noise(const db::Catalog& catalog, const std::string& serial, bool simulated) {
  const auto still = still_segment(catalog, serial);
  if (!still) return base::forward_error(still);
  if (still->run.simulated && !simulated) {
    return base::bad_input(fmt::format(
        "run {} of unit {} comes from SIMULATED data; --simulated exports it all the same", still->run.label, serial));
  }
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  UnitNoise noise{source_of(*still, **unit), {}};
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
