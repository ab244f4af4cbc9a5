// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/run.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// What identifies a segment: contiguous recorded rows of one unit with the same run, plateau, position and phase.
struct SegmentKey {
  std::string run_id;
  std::string unit;          ///< serial number
  std::int32_t visit = 0;    ///< ordinal of the plateau in the run, from 0
  std::string position;      ///< label; empty = one attitude throughout; "rest 1"... of standstills that were found
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

/// How bad a finding of the data gate is: `reject` keeps what it names out of every fit, `warn` is for people.
enum class Severity : std::uint8_t { warn, reject };

constexpr std::string_view name_of(Severity severity) { return severity == Severity::reject ? "reject" : "warn"; }
constexpr Severity severity_named(std::string_view name) {
  return name == "reject" ? Severity::reject : Severity::warn;
}

/// What the data gate (data_gate.h) found in the samples of one segment.
struct Finding {
  std::string code;  ///< stable: docs/fit.md lists them
  Severity severity = Severity::warn;
  std::optional<Sensor> sensor;  ///< that it concerns; absent = the whole segment
  std::string text;              ///< a sentence with the numbers: what was seen, and what would be right

  bool operator==(const Finding&) const = default;
};

/// Statistics of one segment.
struct Segment {
  SegmentKey key;
  Phase phase = Phase::soak;
  Sweep sweep = Sweep::unknown;
  std::optional<double> plateau_c;   ///< set point, given or found; it groups and never regresses
  std::optional<Position> position;  ///< absent = unknown: one attitude, or is_found_rest()
  double t_start_s = 0.0;
  double t_end_s = 0.0;
  double temp_c = 0.0;  ///< mean of the unit's own thermometer
  double temp_rate_kpmin = 0.0;
  std::array<double, kSensorCount>
      sensor_temp_c{};  ///< mean of each sensor's thermometer; the unit's where it has none
  std::array<SensorStatistics, kSensorCount> sensor;
  std::vector<Block> blocks;
  std::vector<Finding> findings;  ///< empty = nothing was found
};

/// Whether the fixture turns in the segment at a known rate other than 0.
inline bool turns(const Segment& segment) {
  return segment.position && segment.position->rate_dps.value_or(0.0) != 0.0;
}

/// Whether it is a standstill that was found in a recording without positions (segmentation.h): at rest in an attitude
/// that nobody knows.
inline bool is_found_rest(const Segment& segment) { return !segment.position && !segment.key.position.empty(); }

}  // namespace soak::calib
