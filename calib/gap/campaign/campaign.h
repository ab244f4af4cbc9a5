// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/sensor.h"

/// The gap workflow: what a simulation of the campaign does not explain of the measurement, and which effect that is.
namespace soak::calib::gap {

/// What single samples of a sensor say that means of blocks do not.
struct SampleFacts {
  std::size_t count = 0;
  std::optional<double> step;  ///< distance of the lattice that the values lie on, SI; absent = none is seen
  double noise = 0.0;          ///< standard deviation from sample to sample, SI
  double low_rail = 0.0;
  double high_rail = 0.0;
  std::size_t at_rails = 0;  ///< samples that stick at the lowest or highest value; 0 where those are chance

  /// Those of two runs together: the coarser step, the smaller noise, rails added.
  void add(const SampleFacts& other);
};

/// Step of a thermometer from which temperatures cannot be told well enough within it.
inline constexpr double kCoarseStep_c = 0.1;

/// Facts of one sensor's samples in the order of time; NaN = missing. A lattice is seen where distances between
/// neighbouring distinct values are multiples of one step, coarser than the digits that the values have; rails where at
/// least 10 samples are the very lowest (highest) value and ten times as many as the value next to it has. Up to 20000
/// samples, evenly chosen, are looked at for the lattice; all for the rails.
[[nodiscard]] SampleFacts sample_facts(std::span<const double> samples);

/// What a run's recording logged from its first row to its last, ramps included: means over bins of equal length in
/// device time. All vectors have the length of `t_s`; NaN where a channel gave no value, and a channel that nobody
/// recorded is empty.
struct RunLog {
  std::vector<double> t_s;              ///< middle of the bin
  std::vector<double> temp_c;           ///< the unit's own thermometer
  std::vector<double> t_since_power_s;  ///< time since power-on
  std::vector<double> chamber_c;        ///< air
  std::vector<double> compressor;       ///< duty, 0 to 1
  std::vector<double> supply_v;
};

/// Bins of 10 s, or of the median distance between rows where that is longer; bins without a row are left out.
/// Auxiliary channels by name: chamber_c, compressor, supply_v. Where the recording does not know the time since
/// power-on, its first row is at power-on. Cost linear in rows.
[[nodiscard]] RunLog make_run_log(const Recording& recording);

/// A run with what the station logged between its segments.
struct LoggedRun {
  RunInput run;
  RunLog log;
  std::optional<double> start_utc_s;  ///< Unix time of device time 0
};

/// Temperatures within the steps of a coarse thermometer, from the chamber's air (fine_temperature.h).
struct FineTemperature {
  double step_c = 0.0;            ///< of the thermometer
  double error_c = 0.0;           ///< RMS, where the reading changes
  std::array<double, 2> tau_s{};  ///< with which the unit follows the air
};

/// All runs of one unit that a gap is looked for in.
struct LoggedCampaign {
  std::string unit;
  UnitType type;
  std::vector<LoggedRun> runs;
  SampleFacts thermometer;                          ///< of the unit's own; no step where its temperatures were refined
  std::optional<FineTemperature> fine_temperature;  ///< absent = temperatures are as the thermometer showed them
  std::array<SampleFacts, kSensorCount> samples{};  ///< of all runs; count 0 = nobody looked
  std::vector<ModelTerm> carried;  ///< by the unit's model; what they do to means is taken off the segments
};

/// Whether some run rests at a plateau; else its recordings are judged by branches.
[[nodiscard]] bool has_plateaus(const LoggedCampaign& campaign);

}  // namespace soak::calib::gap
