// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/scale_nonlinearity.h"

namespace soak::hal::sim {
namespace {

class ScaleNonlinearity final : public Effect {
 public:
  void advance_to(const Conditions& now) override { up_ = now.up; }

  [[nodiscard]] double response(calib::Sensor sensor) const override {
    if (calib::is_gyro(sensor)) return 0.0;
    const double force_g = up_[calib::axis_of(sensor)];
    return force_g * force_g;
  }

 private:
  calib::Vector3 up_{};
};

}  // namespace

std::unique_ptr<Effect> make_scale_nonlinearity(const EffectOrder&, ShapeDraws&) {
  return std::make_unique<ScaleNonlinearity>();
}

}  // namespace soak::hal::sim
