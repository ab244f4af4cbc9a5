// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/result.h"
#include "calib/signal/documents/signal_json.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// One column of a CSV file that has a header line. With a time column (`t_s`, `t_ms`, `t_us`) the times place the
/// samples and give the rate; without one every row is a sample and `rate_hz` is required. Empty cells are missing
/// samples. Numbers stay as they are in the file; the unit is what the column's suffix says ("gx_dps",
/// "rate_dps": deg/s). Refuses, with line and column, what is no number or beyond 1e100, times that do not rise, a
/// column that is not there or there twice (listing those that are), and a `rate_hz` that the times contradict by more
/// than 1 %.
[[nodiscard]] base::Result<calib::SignalRecord> read_csv_signal(const std::filesystem::path& path,
                                                                const std::string& column,
                                                                std::optional<double> rate_hz);

/// Part of a stored run.
struct RunPart {
  db::RunFilter run;
  std::optional<std::int32_t> visit;            ///< only segments of this visit
  std::optional<std::string> position;          ///< only segments in this position
  std::optional<std::int32_t> attempt = {};     ///< only segments of this attempt
  std::optional<std::uint64_t> most_rows = {};  ///< no more are read
};

/// One channel of a stored run, in deg/s and m/s²: the rows of its segments that no void record withdraws, each segment
/// a stretch of its own; those that the data gate rejected, whole or for this sensor, are left out. `channel` is a name
/// of `soak runs show` (gyro_x) or of canonical CSV (gx_dps). Where the run has no segments that match, it is refused
/// with those it has. Reads times and samples of the segments
/// only.
[[nodiscard]] base::Result<calib::SignalRecord> read_run_signal(const db::Catalog& catalog, const RunPart& part,
                                                                const std::string& channel);

}  // namespace soak::station
