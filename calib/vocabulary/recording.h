// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/run.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// A channel that no sensor of the unit gave: chamber air, supply, compressor duty...
struct AuxiliaryChannel {
  std::string name;            ///< with its unit as suffix: "chamber_c", "supply_v"
  std::vector<double> values;  ///< one per row; NaN = no new value
};

/// The rows of one unit in one run, converted to SI (rad/s, m/s², s, °C). All vectors that are not empty have the
/// length of `t_s`; NaN in a row means that the channel gave no new value there.
struct Recording {
  std::string run_id;                                           ///< UUID of the run
  std::string unit;                                             ///< serial number
  std::vector<double> t_s;                                      ///< device time, strictly rising
  std::vector<double> temp_c;                                   ///< the unit's own thermometer
  std::array<std::vector<double>, kSensorCount> sensor;         ///< empty = not recorded
  std::array<std::vector<double>, kSensorCount> sensor_temp_c;  ///< thermometer of that sensor; empty = none
  std::vector<Phase> phase;                                     ///< empty = soak throughout
  std::vector<Sweep> sweep;                                     ///< empty = unknown
  std::vector<double> plateau_c;                                ///< set point; empty = not recorded
  std::vector<Position> positions;                              ///< the distinct positions of the run
  std::vector<std::int32_t> position;   ///< index into `positions`, -1 = moving; empty = one attitude throughout
  std::vector<double> t_since_power_s;  ///< empty = the run starts at power-on
  std::vector<AuxiliaryChannel> auxiliary;

  [[nodiscard]] std::size_t rows() const { return t_s.size(); }
};

}  // namespace soak::calib
