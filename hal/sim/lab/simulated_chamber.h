// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "hal/sim/lab/chamber_plant.h"
#include "hal/sim/lab/register_table.h"

namespace soak::hal::sim {

/// A temperature chamber with a Watlow F4T as its controller: physics, control, and the registers of data map 1. It
/// does what is written to its registers and nothing else; control is off at the start.
class SimulatedChamber {
 public:
  SimulatedChamber(const LabMagnitudes& magnitudes, std::uint64_t seed);
  SimulatedChamber(const SimulatedChamber&) = delete;
  SimulatedChamber& operator=(const SimulatedChamber&) = delete;

  /// Advances by `dt_s`.
  void step(double dt_s);

  /// Of data map 1.
  [[nodiscard]] RegisterTable& registers() { return registers_; }
  [[nodiscard]] const ChamberPlant& plant() const { return plant_; }

  // What other controllers in its place would show and take.
  /// A reading of the air's sensor.
  [[nodiscard]] double process_value_c() const;
  /// Output that heater and refrigeration really get, −1 to 1: the limit protector cuts the heater.
  [[nodiscard]] double applied_output() const;
  [[nodiscard]] const TemperatureController& controller() const { return controller_; }
  [[nodiscard]] double set_point_low_c() const { return set_point_low_c_; }
  [[nodiscard]] double set_point_high_c() const { return set_point_high_c_; }
  [[nodiscard]] bool takes_set_point(double set_point_c) const {
    return set_point_c >= set_point_low_c_ && set_point_c <= set_point_high_c_;
  }
  void set_set_point_c(double set_point_c) { controller_.set_set_point_c(set_point_c); }
  void switch_control(bool on) { controller_.switch_control(on); }
  [[nodiscard]] bool alarm_is_on() const { return alarm_.tripped(); }
  [[nodiscard]] bool limit_is_tripped() const { return limit_.tripped(); }

 private:
  void add_loop_registers();
  void add_ramp_registers();
  void add_alarm_registers();
  void add_identity_registers();
  void apply_ramp();

  ControllerMagnitudes magnitudes_;
  std::uint64_t seed_;
  std::uint64_t step_ = 0;
  ChamberPlant plant_;
  TemperatureController controller_;
  LatchedTrip alarm_;
  LatchedTrip limit_;
  double set_point_low_c_;
  double set_point_high_c_;
  double alarm_low_c_;
  int ramp_action_;
  int ramp_scale_;
  double ramp_rate_ = 1.0;  ///< K per ramp_scale_
  std::array<int, 8> events_;
  RegisterTable registers_;
};

}  // namespace soak::hal::sim
