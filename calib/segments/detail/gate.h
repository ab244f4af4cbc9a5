// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/segments/data_gate.h"

/// What the data gate keeps of a recording's samples (gate_facts.cpp), and the checks that judge it: of one sensor in
/// one segment (sample_checks.cpp), of motion (motion_checks.cpp) and of the position's label (wrong_position.cpp).
namespace soak::calib::gate {

/// Stretch of rows of a segment, counted from its first row.
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
  double duration_s = 0.0;
};

/// Cuts a segment into stretches of 10 s, at least six, each of two rows or more; empty for fewer than twelve rows.
[[nodiscard]] std::vector<Stretch> stretches(std::span<const double> t_s);

/// A sample far outside the noise.
struct Hit {
  std::size_t row = 0;
  double residual = 0.0;  ///< distance from the median of its stretch
};

/// One sensor's level, stretch by stretch, and what stands out of it.
struct Levels {
  double sigma = 0.0;        ///< spread about the levels; 0 = no noise, and nothing stands out
  std::vector<double> mean;  ///< per stretch, without short bursts; NaN = no sample
  std::vector<Hit> hits;     ///< in the order of rows, short or long
};

/// Hits follow each other within this time, or from row to row, to make one burst.
inline constexpr double kBurstGap_s = 0.05;

/// `values` has one value per row, NaN = no sample. sigma is 1.48 times the median distance from the medians of the
/// stretches (of at most some hundred samples of each), and at least `least_sigma`; samples beyond `sigmas` of it are
/// hits. Bursts of hits up to a quarter of a second, or of three rows, are no part of the means: a bad sample or a
/// knock is not motion. Whoever turns a unit by hand takes longer.
[[nodiscard]] Levels levels_of(std::span<const double> t_s, std::span<const double> values,
                               std::span<const Stretch> stretches, double least_sigma, double sigmas);

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
  bool complete = false;            ///< no sample is missing
  std::size_t samples = 0;          ///< that are there
  Levels levels;                    ///< empty without stretches
  std::vector<std::size_t> spikes;  ///< rows that stand alone and are left out of the means
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

/// Gathers the usual distance between times, segment by segment.
class Intervals {
 public:
  void add(std::span<const double> times);
  [[nodiscard]] double usual_s() const;

 private:
  std::vector<double> intervals_;  ///< the first of all, as many as are looked at
};

/// Gathers the step of a thermometer that only ever jumps by multiples of one number, from rows in order, in pieces of
/// any length.
class ThermometerJumps {
 public:
  void add(std::span<const double> t_s, std::span<const double> temp_c);
  /// 0 for any other.
  [[nodiscard]] double step_c() const;

 private:
  std::vector<double> jumps_;                      ///< the first of all, as many as are looked at
  std::optional<std::pair<double, double>> last_;  ///< time and temperature of the last row
};

/// Gathers what the segments show of one sensor, segment by segment, with the samples of one in memory at a time.
class FactGatherer {
 public:
  FactGatherer();
  FactGatherer(FactGatherer&&) noexcept;
  FactGatherer& operator=(FactGatherer&&) noexcept;
  ~FactGatherer();
  void add(const Present& present);
  /// `row_interval_s`: the interval where no sample is missing.
  [[nodiscard]] SensorFacts facts(double row_interval_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sets `positions_differ` and `plateaus_differ`.
void note_differences(std::span<const Segment> segments, Facts& facts);

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

// Of one sensor in one segment, while its samples are in memory.

struct KnownTimes;
/// Fills the sensor's summary in `state`, which is that of `segment`. `known`: what is known of the times of the
/// segment's rows, or becomes known now.
void summarise(const View& segment, Sensor sensor, const Present& present, std::span<const double> values,
               SegmentState& state, KnownTimes& known);

/// Samples at the range of the type, or piled up at the extreme value.
[[nodiscard]] std::optional<Finding> saturated(const Samples& samples);
/// The same value bit for bit for longer than chance allows. Not asked where the sensor is saturated.
[[nodiscard]] std::optional<Finding> stuck(const Samples& samples);
/// Time without values, of a segment.
struct Loss {
  double share = 0.0;
  double longest_s = 0.0;
};
/// Of values at `times`, usually `interval_s` apart, in a segment of these rows.
[[nodiscard]] Loss loss_of(std::span<const double> t_s, std::span<const double> times, double interval_s);
/// Share of samples that are missing.
[[nodiscard]] std::optional<Finding> dropouts(const Samples& samples, const Loss& loss);
/// Share of the intervals that differ from the usual one by more than half of it; nothing where there are too few.
[[nodiscard]] std::optional<double> share_off(std::span<const double> times, double interval_s);
/// What the times of a segment's rows say, for the sensors of which no sample is missing.
struct KnownTimes {
  double interval_s = 0.0;  ///< usual one that they were judged by
  Loss loss;
  std::optional<double> share_off;
};
/// Intervals that differ from the usual one. Not asked where samples are missing.
[[nodiscard]] std::optional<Finding> irregular_sampling(const Samples& samples, double share);

// Of a segment, from what is kept of its sensors.

/// Appends what it found; `findings` holds those of the checks before it.
using Check = void (*)(const View& view, std::vector<Finding>& findings);

/// Direction of the specific force between stretches, and angles that the gyros turn through.
void moved(const View& view, std::vector<Finding>& findings);
/// Bursts in several sensors at once. Silent where the unit has moved: that explains them.
void knocked(const View& view, std::vector<Finding>& findings);
/// Mean specific force against the position's up vector.
void wrong_position(const View& view, std::vector<Finding>& findings);
/// What was found in each sensor's samples, check by check.
void sensor_findings(const View& view, std::vector<Finding>& findings);
/// Steps of the thermometers.
void coarse_thermometer(const View& view, std::vector<Finding>& findings);

inline constexpr std::array<Check, 5> kChecks = {moved, knocked, wrong_position, sensor_findings, coarse_thermometer};

}  // namespace soak::calib::gate
