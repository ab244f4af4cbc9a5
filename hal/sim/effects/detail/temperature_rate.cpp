// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/temperature_rate.h"

namespace soak::hal::sim {
namespace {

class TemperatureRate final : public Effect {
 public:
  explicit TemperatureRate(double slope_pk) : slope_pk_(slope_pk) {}

  void advance_to(const Conditions& now) override {
    const double passed_min = (now.time_s - time_s_) / 60.0;
    if (started_ && passed_min > 0.0) rate_kpmin_ = (now.thermometer_c - temp_c_) / passed_min;
    started_ = true;
    time_s_ = now.time_s;
    temp_c_ = now.thermometer_c;
  }

  [[nodiscard]] double response(calib::Sensor) const override {
    return rate_kpmin_ * (1.0 + slope_pk_ * (temp_c_ - 25.0));
  }

 private:
  double slope_pk_;
  bool started_ = false;
  double time_s_ = 0.0;
  double temp_c_ = 0.0;
  double rate_kpmin_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_temperature_rate(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<TemperatureRate>(shape.within("slope_pk", {-0.006, 0.006}));
}

}  // namespace soak::hal::sim
