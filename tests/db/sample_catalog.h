// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "db/catalog/catalog.h"
#include "tests/calib/same_segment.h"
#include "tests/db/support.h"

/// A small catalog with one of everything; the files of version 1 were made from it.
namespace soak::db::testing {

inline constexpr const char* kRunId = "01890a5d-ac96-774b-bcce-b302099a8057";

inline RunRow run_row(std::string run_id = kRunId, std::string label = "r1", std::string unit = "SN1") {
  RunRow run;
  run.run_id = std::move(run_id);
  run.unit = std::move(unit);
  run.campaign = "c1";
  run.label = std::move(label);
  run.procedure = "soak";
  run.created_utc_s = 1700000000.125;
  run.clock_rate = 20.0;
  run.simulated = true;
  run.sealed = true;
  run.file_name = run.run_id + ".soakrun";
  run.file_sha256 = std::string(64, 'a');
  run.content_sha256 = std::string(64, 'b');
  run.site.latitude_deg = -33.85;
  run.rows = 123456789012;
  run.duration_s = 126000.5;
  return run;
}

/// A segment whose every number differs from every other.
inline calib::Segment segment(std::string run_id, std::string unit, std::int32_t visit, std::string position,
                              std::int32_t attempt, double t_start_s) {
  calib::Segment segment;
  segment.key = {std::move(run_id), std::move(unit), visit, position, attempt};
  segment.phase = calib::Phase::ramp;
  segment.sweep = calib::Sweep::down;
  segment.plateau_c = -40.0 + visit;
  segment.position = calib::position_named(position);
  if (segment.position) segment.position->rate_dps = 36.1;
  segment.t_start_s = t_start_s;
  segment.t_end_s = t_start_s + 99.5;
  segment.temp_c = -39.123456789;
  segment.temp_rate_kpmin = 1e-5;
  double number = t_start_s + 1.0 / 3.0;
  for (double& temp_c : segment.sensor_temp_c) temp_c = number += 1.0;
  segment.blocks.resize(2);
  for (auto* sensors : {&segment.sensor, &segment.blocks[0].sensor, &segment.blocks[1].sensor}) {
    for (calib::SensorStatistics& sensor : *sensors) {
      sensor = {static_cast<std::size_t>(number), number + 0.1, number + 0.2, number + 0.3};
      number += 1.0;
    }
  }
  for (std::size_t i = 0; i < segment.blocks.size(); ++i) {
    calib::Block& block = segment.blocks[i];
    block.t_s = t_start_s + 30.0 * static_cast<double>(i);
    block.duration_s = 60.0;
    block.temp_c = 20.0 + static_cast<double>(i);
    block.temp_rate_kpmin = 0.25;
    for (double& temp_c : block.sensor_temp_c) temp_c = number += 1.0;
  }
  return segment;
}

inline std::vector<calib::Segment> segments_of(const RunRow& run) {
  return {segment(run.run_id, run.unit, 0, "+X", 0, 0.0), segment(run.run_id, run.unit, 0, "-X", 0, 100.0),
          segment(run.run_id, run.unit, 0, "+X", 1, 200.0), segment(run.run_id, run.unit, 1, "", 0, 300.0)};
}

/// Fills an empty catalog: units, a campaign, a run with four segments of which one is void, two models, a calibration.
inline void fill(Catalog& catalog) {
  ASSERT_TRUE(catalog.ensure_unit("SN1", "generic"));
  ASSERT_TRUE(catalog.ensure_campaign("c1", "soak"));
  const auto added = catalog.add_run(run_row(), segments_of(run_row()));
  ASSERT_TRUE(added) << added.error().message;
  ASSERT_TRUE(catalog.add_void({kRunId, "SN1", 0, "-X", 0, "fixture slipped", "ann", 1700000100.0}));
  for (const double utc_s : {1700000200.0, 1700000300.0}) {
    ASSERT_TRUE(catalog.add_model(
        "SN1", 0, utc_s, [](std::int32_t version) { return "{\"version\": " + std::to_string(version) + "}"; }));
  }
  ASSERT_TRUE(catalog.add_calibration({"SN1", 2, 1700000400.0, "blob", std::string(64, 'c'), "sn1.blob"}));
  ASSERT_TRUE(catalog.log_event({1700000500.0, "note", "SN1", "looks good"}));
}

}  // namespace soak::db::testing
