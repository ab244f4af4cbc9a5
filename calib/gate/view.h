// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/data_gate.h"

namespace soak::calib::gate {

/// What the segments of a recording show of one sensor as a whole; a single segment may have too little of it.
struct SensorFacts {
  double interval_s = 0.0;    ///< usual distance between values (of bursts: their mean); 0 = fewer than two
  double step = 0.0;          ///< smallest difference between neighbouring values; 0 = one number throughout
  double noise = 0.0;         ///< white noise of one sample, median over stretches that are not constant; 0 = none
  std::size_t usual_run = 0;  ///< length that 99 % of the runs of equal values do not exceed
  bool one_number = false;    ///< there are values, and all of them are the same
};

struct Facts {
  bool circumstances_differ = false;  ///< positions or plateaus: a live sensor cannot read one number in all segments
  std::array<SensorFacts, kSensorCount> sensor;
  double temp_step_c = 0.0;  ///< of the unit's thermometer; 0 = none that is coarse
  std::array<double, kSensorCount> sensor_temp_step_c{};
};

/// `segments` and their rows are those of examine().
[[nodiscard]] Facts collect_facts(const Recording& recording, std::span<const Segment> segments);

/// One segment as the checks see it.
struct View {
  const Recording& recording;
  const Segment& segment;
  const UnitType& type;
  const GateLimits& limits;
  const Facts& facts;
  std::size_t first = 0;  ///< rows [first, last) of the recording
  std::size_t last = 0;

  [[nodiscard]] std::size_t rows() const { return last - first; }
  [[nodiscard]] std::span<const double> t_s() const { return {recording.t_s.data() + first, rows()}; }
  /// Empty where the sensor was not recorded.
  [[nodiscard]] std::span<const double> values(Sensor sensor) const {
    const std::vector<double>& all = recording.sensor[index_of(sensor)];
    return all.empty() ? std::span<const double>() : std::span<const double>(all.data() + first, rows());
  }
  [[nodiscard]] std::span<const double> temp_c() const {
    return recording.temp_c.empty() ? std::span<const double>()
                                    : std::span<const double>(recording.temp_c.data() + first, rows());
  }
  [[nodiscard]] const SensorFacts& facts_of(Sensor sensor) const { return facts.sensor[index_of(sensor)]; }
};

/// Rows [first, last) of a recording in which the segment lies, by its device times.
[[nodiscard]] std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment);

/// Whether a code stands among the findings, for any sensor or for this one.
[[nodiscard]] bool has(const std::vector<Finding>& findings, std::string_view code);
[[nodiscard]] bool has(const std::vector<Finding>& findings, std::string_view code, Sensor sensor);

/// Values that are not NaN.
[[nodiscard]] std::vector<double> present(std::span<const double> values);
/// Times of the values that are not NaN.
[[nodiscard]] std::vector<double> times_of(std::span<const double> t_s, std::span<const double> values);
/// Mean of the values that are not NaN; NaN without any.
[[nodiscard]] double mean_of(std::span<const double> values);

/// Stretch of rows of a segment, counted from its first row.
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
  double duration_s = 0.0;
};

/// Cuts a segment into stretches of 10 s, at least six, each of two rows or more; empty for fewer than twelve rows.
[[nodiscard]] std::vector<Stretch> stretches(std::span<const double> t_s);

}  // namespace soak::calib::gate
