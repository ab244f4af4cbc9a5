// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/segments/data_gate.h"
#include "calib/segments/detail/levels.h"

namespace soak::calib::gate {

/// What the segments of a recording show of one sensor as a whole; a single segment may have too little of it.
struct SensorFacts {
  double interval_s = 0.0;    ///< usual distance between values (of bursts: their mean); 0 = fewer than two
  double step = 0.0;          ///< smallest difference between neighbouring values; 0 = one number throughout
  double noise = 0.0;         ///< white noise of one sample, median over stretches that are not constant; 0 = none
  bool many_codes = false;    ///< at least half of those stretches show three steps or more
  std::size_t usual_run = 0;  ///< length that 99 % of the runs of equal values do not exceed
  bool one_number = false;    ///< there are values, and all of them are the same
};

/// What the labels of a recording's positions say against its accelerometers.
struct AttitudeFacts {
  Vector3 bias{};         ///< common to all positions, m/s^2; 0 where there are too few to tell
  bool reversed = false;  ///< every accelerometer reads the opposite of every label
};

struct Facts {
  bool positions_differ = false;  ///< a live accelerometer cannot read one number in all segments
  bool plateaus_differ = false;   ///< no live sensor can
  std::array<SensorFacts, kSensorCount> sensor;
  AttitudeFacts attitude;
  double temp_step_c = 0.0;  ///< of the unit's thermometer; 0 = none that is coarse
  std::array<double, kSensorCount> sensor_temp_step_c{};
};

/// The samples of one sensor that are there, with their times. No copies where none is missing.
class Present {
 public:
  /// `complete`: none is known to be missing; nobody looks then.
  Present(std::span<const double> t_s, std::span<const double> values, bool complete);
  Present(const Present&) = delete;
  Present& operator=(const Present&) = delete;
  Present(Present&&) = default;
  Present& operator=(Present&&) = default;

  [[nodiscard]] std::span<const double> values() const { return values_; }
  [[nodiscard]] std::span<const double> t_s() const { return t_s_; }
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  std::vector<double> own_values_;
  std::vector<double> own_t_s_;
  std::span<const double> values_;
  std::span<const double> t_s_;
  bool complete_ = true;
};

/// What stays of one sensor's samples in one segment.
struct SensorSummary {
  bool recorded = false;
  bool complete = false;    ///< no sample is missing
  std::size_t samples = 0;  ///< that are there
  Levels levels;            ///< empty without stretches
  std::optional<Finding> saturated;
  std::optional<Finding> stuck;
  std::optional<Finding> dropouts;
  bool sampling_judged = false;  ///< whether anything can be said of the next one
  std::optional<Finding> irregular_sampling;
};

/// Rows [first, last) of a segment, and what stays of its samples.
struct SegmentState {
  std::size_t first = 0;
  std::size_t last = 0;
  std::vector<Stretch> stretches;
  std::array<SensorSummary, kSensorCount> sensor;
};

/// One segment as the checks see it.
struct View {
  const Recording& recording;         ///< without the samples of its sensors
  std::span<const Segment> segments;  ///< of the whole recording
  const Segment& segment;
  const UnitType& type;
  const GateLimits& limits;
  const Facts& facts;
  const SegmentState& state;

  [[nodiscard]] std::size_t rows() const { return state.last - state.first; }
  [[nodiscard]] std::span<const double> t_s() const { return {recording.t_s.data() + state.first, rows()}; }
  [[nodiscard]] std::span<const double> temp_c() const {
    return recording.temp_c.empty() ? std::span<const double>()
                                    : std::span<const double>(recording.temp_c.data() + state.first, rows());
  }
  [[nodiscard]] const SensorFacts& facts_of(Sensor sensor) const { return facts.sensor[index_of(sensor)]; }
  [[nodiscard]] const SensorSummary& summary_of(Sensor sensor) const { return state.sensor[index_of(sensor)]; }
  [[nodiscard]] const Levels& levels_of(Sensor sensor) const { return summary_of(sensor).levels; }
};

/// One sensor's samples in a segment, as long as they are in memory.
struct Samples {
  const View& view;
  Sensor sensor;
  const Present& present;

  [[nodiscard]] const SensorFacts& facts() const { return view.facts_of(sensor); }
};

/// What the recording and its segments show without the sensors. `sensor` and `attitude` are left empty.
[[nodiscard]] Facts run_facts(const Recording& recording, std::span<const Segment> segments);
/// Usual distance in time between rows.
[[nodiscard]] double row_interval_s(const Recording& recording, std::span<const SegmentState> states);
/// `presents`: the sensor's samples in each segment; their interval is that of the rows where none is missing.
[[nodiscard]] SensorFacts sensor_facts(std::span<const Present> presents, double row_interval_s);
/// `segments` with the statistics of all sensors.
[[nodiscard]] AttitudeFacts attitude_facts(std::span<const Segment> segments, const UnitType& type);

/// Rows [first, last) of a recording in which the segment lies, by its device times.
[[nodiscard]] std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment);

/// Whether a code stands among the findings as a rejection of anything.
[[nodiscard]] bool rejected_as(const std::vector<Finding>& findings, std::string_view code);

/// Mean of the values that are not NaN; NaN without any.
[[nodiscard]] double mean_of(std::span<const double> values);

/// Output step: as the type states, else the smallest difference seen.
[[nodiscard]] double step_of(const View& view, Sensor sensor);

}  // namespace soak::calib::gate
