// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/vibration_rectification.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class VibrationRectification final : public Effect {
 public:
  explicit VibrationRectification(double spin_up_s) : spin_up_s_(spin_up_s) {}

  void advance_to(const Conditions& now) override {
    const double stays = started_ ? std::exp(-(now.time_s - time_s_) / spin_up_s_) : 0.0;
    level_ = now.compressor + (level_ - now.compressor) * stays;
    started_ = true;
    time_s_ = now.time_s;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return level_ * level_; }

 private:
  double spin_up_s_;
  bool started_ = false;
  double time_s_ = 0.0;
  double level_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_vibration_rectification(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<VibrationRectification>(shape.within("spin_up_s", {1.0, 8.0}));
}

}  // namespace soak::hal::sim
