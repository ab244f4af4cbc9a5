// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/lab/device_time.h"

namespace soak::hal::sim {

/// One axis of a fixture: goes to an angle at a constant speed, or turns at a rate that it reaches at a constant
/// acceleration. A function of the commands and their times: however time is divided, it stands where it stands.
class TurningAxis {
 public:
  explicit TurningAxis(double speed_dps) : speed_dps_(speed_dps) {}

  /// From where it stands, which counts as `from_deg`, on a straight way.
  void go_to(double from_deg, double angle_deg, Tick now);
  void turn_at(double rate_dps, Tick now);

  /// Turns are counted: 370° is one turn and 10°.
  [[nodiscard]] double angle_deg(Tick now) const;
  [[nodiscard]] double rate_dps(Tick now) const;
  /// Has come to the angle or to the rate.
  [[nodiscard]] bool settled(Tick now) const;

 private:
  [[nodiscard]] double since_s(Tick now) const;

  double speed_dps_;
  Tick start_ = 0;
  double start_deg_ = 0.0;
  double start_dps_ = 0.0;
  double change_s_ = 0.0;  ///< until the rate is reached
  double dps_ = 0.0;       ///< from then on
  double end_s_ = 0.0;     ///< of the way to an angle; turning at a rate has none
  double end_deg_ = 0.0;
  bool ends_ = true;
};

}  // namespace soak::hal::sim
