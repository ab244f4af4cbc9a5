// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/config/lab_magnitudes.h"

namespace soak::hal::sim {

/// Heat of the chamber: an air node that heater, refrigeration, load and room act on, and a load node that follows the
/// air. With m the heat capacity of the load over that of the air:
///
///   dTair/dt  = q + (m/τload)·(Tload − Tair) + ((1 + m)/τleak)·(Troom − Tair)
///   dTload/dt = (Tair − Tload)/τload
///
/// q is (1 + m) times the stated rate of heating or cooling at full power.
class ChamberPlant {
 public:
  /// Air and load start at room temperature.
  explicit ChamberPlant(const PlantMagnitudes& magnitudes);

  /// Advances by `dt_s` (explicit Euler: well below the shortest time constant) with the output that the controller
  /// asks for, from −1 (full refrigeration) to +1 (full heat).
  void step(double dt_s, double output);

  [[nodiscard]] double air_c() const { return air_c_; }
  [[nodiscard]] double load_c() const { return load_c_; }
  /// Whether the compressor is in the running half of its cycle while there is something to cool.
  [[nodiscard]] bool compressor_runs() const;

 private:
  /// Cooling relative to its mean at this moment of the compressor's cycle.
  [[nodiscard]] double compressor_cycle() const;
  [[nodiscard]] bool in_running_half() const { return compressor_s_ < 0.5 * magnitudes_.compressor_period_s; }

  PlantMagnitudes magnitudes_;
  double air_c_;
  double load_c_;
  double heater_ = 0.0;         ///< share of full power
  double refrigeration_ = 0.0;  ///< share of full power
  double compressor_s_ = 0.0;   ///< time in the compressor's cycle
};

/// Temperature of one unit in the chamber: (Tair + self-heating − T)/τ + (Tload − T)/τload.
class UnitHeat {
 public:
  UnitHeat(double start_c, double settling_time_s, double load_coupling_time_s, double self_heating_c)
      : temp_c_(start_c),
        settling_time_s_(settling_time_s),
        load_coupling_time_s_(load_coupling_time_s),
        self_heating_c_(self_heating_c) {}

  void step(double dt_s, const ChamberPlant& chamber, bool powered);
  [[nodiscard]] double temp_c() const { return temp_c_; }

 private:
  double temp_c_;
  double settling_time_s_;
  double load_coupling_time_s_;
  double self_heating_c_;
};

}  // namespace soak::hal::sim
