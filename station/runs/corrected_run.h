// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/sensor.h"

namespace soak::station {

/// What a device that holds a calibration file makes of a stretch of a recording: means over its rows, SI.
struct CorrectedBlock {
  double t_s = 0.0;  ///< middle of its rows
  double temp_c = 0.0;
  std::string position;  ///< the recording's name of it; empty where it has none
  std::array<std::optional<double>, calib::kSensorCount> raw;
  std::array<std::optional<double>, calib::kSensorCount> corrected;  ///< absent where the runtime left all rows raw
};

/// A recording as a device would have corrected it.
struct CorrectedRun {
  std::vector<CorrectedBlock> blocks;
  std::size_t rows = 0;     ///< with a temperature
  std::size_t clamped = 0;  ///< of these, rows out of some sensor's range
  bool moving = false;      ///< the file has terms of soak_terms.h
  bool history = false;     ///< and of soak_history.h
  /// Largest share of a correction for thermal history that is still unknown at the end, 0 to 1.
  double unknown_at_end = 0.0;
};

/// Runs the deployment runtime over a recording as firmware would: means of 10 s of the unit's thermometer step the
/// thermal history (`past`: of soak_history_start), each row is corrected; means of blocks of up to 30 s in one
/// position come out, without rows in which the fixture moves. A sensor without a value in a row counts as its last
/// one, and adds nothing to the mean. The rate of the temperature is the slope over four minutes about the row. Fails
/// (corrupt) where the runtime refuses the file.
[[nodiscard]] base::Result<CorrectedRun> correct_run(const base::Bytes& file, const calib::Recording& recording,
                                                     double past);

/// The blocks as CSV in printed units: t_s, temp_c, position, the sensors raw (`gx_dps`) and corrected
/// (`gx_corrected_dps`); an empty cell where there is no value.
[[nodiscard]] std::string corrected_csv(const CorrectedRun& run);

}  // namespace soak::station
