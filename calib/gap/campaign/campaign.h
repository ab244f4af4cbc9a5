// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/estimate/unit_rows.h"
#include "calib/gap/campaign/sample_facts.h"
#include "calib/vocabulary/sensor.h"

/// The gap workflow: what a simulation of the campaign does not explain of the measurement, and which effect that is.
namespace soak::calib::gap {

/// Course of a run from its first row to its last, ramps included: means over bins of equal length in device time. All
/// vectors have the length of `t_s`; NaN where a channel gave no value, and a channel that nobody recorded is empty.
struct RunLog {
  std::vector<double> t_s;              ///< middle of the bin
  std::vector<double> temp_c;           ///< the unit's own thermometer
  std::vector<double> t_since_power_s;  ///< time since power-on
  std::vector<double> chamber_c;        ///< air
  std::vector<double> compressor;       ///< duty, 0 to 1
  std::vector<double> supply_v;
};

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

}  // namespace soak::calib::gap
