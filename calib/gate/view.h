// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/data_gate.h"
#include "calib/gate/levels.h"

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

/// `segments` and their rows are those of examine().
[[nodiscard]] Facts collect_facts(const Recording& recording, std::span<const Segment> segments, const UnitType& type);
[[nodiscard]] AttitudeFacts attitude_facts(std::span<const Segment> segments, const UnitType& type);

/// The samples of one sensor that are there, with their times. No copies where none is missing.
class Present {
 public:
  Present() = default;
  Present(std::span<const double> t_s, std::span<const double> values);
  Present(const Present&) = delete;
  Present& operator=(const Present&) = delete;
  Present(Present&&) = default;
  Present& operator=(Present&&) = default;

  [[nodiscard]] std::span<const double> values() const { return values_; }
  [[nodiscard]] std::span<const double> t_s() const { return t_s_; }

 private:
  std::vector<double> own_values_;
  std::vector<double> own_t_s_;
  std::span<const double> values_;
  std::span<const double> t_s_;
};

/// One segment as the checks see it.
struct View {
  const Recording& recording;
  std::span<const Segment> segments;  ///< of the whole recording
  const Segment& segment;
  const UnitType& type;
  const GateLimits& limits;
  const Facts& facts;
  std::size_t first = 0;  ///< rows [first, last) of the recording
  std::size_t last = 0;
  std::vector<Stretch> stretches = {};
  std::array<Present, kSensorCount> present = {};
  std::array<Levels, kSensorCount> levels = {};  ///< without stretches, or of a sensor that was not recorded: empty

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
  [[nodiscard]] const Present& present_of(Sensor sensor) const { return present[index_of(sensor)]; }
  [[nodiscard]] const Levels& levels_of(Sensor sensor) const { return levels[index_of(sensor)]; }
};

/// Fills in what the checks share: stretches, samples and levels.
void prepare(View& view);

/// Rows [first, last) of a recording in which the segment lies, by its device times.
[[nodiscard]] std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment);

/// Whether a code stands among the findings: as a rejection of anything, or for this sensor.
[[nodiscard]] bool rejected_as(const std::vector<Finding>& findings, std::string_view code);
[[nodiscard]] bool has(const std::vector<Finding>& findings, std::string_view code, Sensor sensor);

/// Mean of the values that are not NaN; NaN without any.
[[nodiscard]] double mean_of(std::span<const double> values);

/// Output step: as the type states, else the smallest difference seen.
[[nodiscard]] double step_of(const View& view, Sensor sensor);

}  // namespace soak::calib::gate
