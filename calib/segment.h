// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/position.h"
#include "calib/run.h"
#include "calib/sensor.h"

namespace soak::calib {

/// What identifies a segment: contiguous recorded rows of one unit with the same run, plateau, position and phase.
struct SegmentKey {
  std::string run_id;
  std::string unit;          ///< serial number
  std::int32_t visit = 0;    ///< ordinal of the plateau in the run, from 0
  std::string position;      ///< label; empty = one attitude throughout
  std::int32_t attempt = 0;  ///< repetition of the position within the visit, from 0

  bool operator==(const SegmentKey&) const = default;
};

/// Mean and spread of one sensor over a stretch of rows, SI. `count` 0: the sensor gave no value there.
struct SensorStatistics {
  std::size_t count = 0;
  double mean = 0.0;
  double variance = 0.0;        ///< of single samples about the mean, n − 1 in the denominator
  double standard_error = 0.0;  ///< of the mean, with the correlation of the noise taken into account
};

/// Block of fixed length inside a segment (one minute; 30 s where a run has no plateaus).
struct Block {
  double t_s = 0.0;         ///< middle, device time
  double duration_s = 0.0;  ///< nominal length
  double temp_c = 0.0;
  double temp_rate_kpmin = 0.0;                      ///< slope of the thermometer in K/min
  std::array<double, kSensorCount> sensor_temp_c{};  ///< as in Segment
  std::array<SensorStatistics, kSensorCount> sensor;
};

/// Statistics of one segment.
struct Segment {
  SegmentKey key;
  Phase phase = Phase::soak;
  Sweep sweep = Sweep::unknown;
  std::optional<double> plateau_c;   ///< set point, given or found; it groups and never regresses
  std::optional<Position> position;  ///< absent = one attitude, unknown
  double t_start_s = 0.0;
  double t_end_s = 0.0;
  double temp_c = 0.0;  ///< mean of the unit's own thermometer
  double temp_rate_kpmin = 0.0;
  std::array<double, kSensorCount>
      sensor_temp_c{};  ///< mean of each sensor's thermometer; the unit's where it has none
  std::array<SensorStatistics, kSensorCount> sensor;
  std::vector<Block> blocks;
};

}  // namespace soak::calib
