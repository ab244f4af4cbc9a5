// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/daily_wave.h"

#include <cmath>
#include <numbers>

namespace soak::hal::sim {
namespace {

class DailyWave final : public Effect {
 public:
  explicit DailyWave(double peak_hour) : peak_hour_(peak_hour) {}

  void advance_to(const Conditions& now) override {
    value_ = std::cos(2.0 * std::numbers::pi * (now.utc_s / 3600.0 - peak_hour_) / 24.0);
  }

  [[nodiscard]] double response(calib::Sensor) const override { return value_; }

 private:
  double peak_hour_;
  double value_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_daily_wave(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<DailyWave>(shape.within("peak_hour", {0.0, 24.0}));
}

}  // namespace soak::hal::sim
