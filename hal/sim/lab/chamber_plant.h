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

/// When the working set point moves at the ramp rate instead of jumping.
struct RampSettings {
  bool at_start = false;      ///< from the process value when control is switched on
  bool at_set_point = false;  ///< when a new set point is given
  double rate_kps = 1.0 / 60.0;
};

/// PI controller of the air's temperature with a working set point that can ramp.
class TemperatureController {
 public:
  explicit TemperatureController(const ControllerMagnitudes& magnitudes, double start_c);

  /// Advances by `dt_s`; `air_c` is where the sensor hangs.
  void step(double dt_s, double air_c);

  void switch_control(bool on);
  void set_set_point_c(double set_point_c) { set_point_c_ = set_point_c; }
  void set_ramp(const RampSettings& ramp) { ramp_ = ramp; }

  [[nodiscard]] bool is_on() const { return on_; }
  [[nodiscard]] double set_point_c() const { return set_point_c_; }
  /// Set point that the output acts on; the process value while control is off.
  [[nodiscard]] double working_set_point_c() const { return on_ ? working_c_ : sensed_c_; }
  /// The air's temperature as the sensor follows it, without noise.
  [[nodiscard]] double sensed_c() const { return sensed_c_; }
  /// −1 (full refrigeration) to +1 (full heat); 0 while control is off.
  [[nodiscard]] double output() const { return output_; }
  [[nodiscard]] const RampSettings& ramp() const { return ramp_; }

 private:
  void move_working_set_point(double dt_s);

  ControllerMagnitudes magnitudes_;
  RampSettings ramp_;
  bool on_ = false;
  bool starting_ = false;  ///< on the way from the process value at the start to the set point
  double set_point_c_;
  double working_c_;
  double sensed_c_;
  double integral_ = 0.0;  ///< share of full output
  double output_ = 0.0;
};

/// An over-temperature protection: trips above its limit and stays tripped until control has been switched off and the
/// temperature is back below.
class LatchedTrip {
 public:
  explicit LatchedTrip(double high_c) : high_c_(high_c) {}

  void check(double temp_c, bool control_on) {
    if (temp_c > high_c_) tripped_ = true;
    if (temp_c < high_c_ && !control_on) tripped_ = false;
  }
  void set_high_c(double high_c) { high_c_ = high_c; }

  [[nodiscard]] double high_c() const { return high_c_; }
  [[nodiscard]] bool tripped() const { return tripped_; }

 private:
  double high_c_;
  bool tripped_ = false;
};

}  // namespace soak::hal::sim
