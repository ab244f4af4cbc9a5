// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/sensor_lag.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class SensorLag final : public Effect {
 public:
  explicit SensorLag(double tau_s) : tau_s_(tau_s) {}

  // Exact where the thermometer moves in a straight line from one moment to the next.
  void advance_to(const Conditions& now) override {
    const double passed_s = now.time_s - time_s_;
    if (!started_) behind_c_ = 0.0;
    if (started_ && passed_s > 0.0 && tau_s_ > 0.0) {
      const double slope_kps = (now.thermometer_c - temp_c_) / passed_s;
      const double settled_c = slope_kps * tau_s_;
      behind_c_ = settled_c + (behind_c_ - settled_c) * std::exp(-passed_s / tau_s_);
    }
    started_ = true;
    time_s_ = now.time_s;
    temp_c_ = now.thermometer_c;
  }

  [[nodiscard]] double element_shift_c() const override { return -behind_c_; }

 private:
  double tau_s_;
  bool started_ = false;
  double time_s_ = 0.0;
  double temp_c_ = 0.0;
  double behind_c_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_sensor_lag(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<SensorLag>(order.amplitude);
}

}  // namespace soak::hal::sim
