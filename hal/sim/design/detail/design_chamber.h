// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/random.h"

namespace soak::hal::sim {

/// Heat and compressor of the chamber in a designed campaign. The set point moves at the ramp rate; the air follows it
/// with 60 s, the load follows the air with 1200 s, and the unit follows both (200 s and 2000 s). The compressor
/// toggles at random, also while the temperature is held: cycles of 400 s on average, three quarters of them on in the
/// cold and one quarter in the heat.
class DesignChamber {
 public:
  DesignChamber(double room_c, base::Random random);

  /// Everything has been at room temperature for long; the compressor goes on from where it was.
  void rest();
  void set_target(double target_c, double ramp_kps);
  void advance(double duration_s);

  [[nodiscard]] double air_c() const { return air_c_; }
  [[nodiscard]] double unit_c() const { return unit_c_; }
  [[nodiscard]] bool compressor_runs() const { return compressor_runs_; }

 private:
  void step(double duration_s);
  [[nodiscard]] double drawn_stay_s();

  double room_c_;
  base::Random random_;
  double target_c_;
  double ramp_kps_ = 0.0;
  double set_point_c_;
  double air_c_;
  double load_c_;
  double unit_c_;
  bool compressor_runs_ = false;
  double stays_s_ = 0.0;  ///< until the compressor toggles
};

}  // namespace soak::hal::sim
