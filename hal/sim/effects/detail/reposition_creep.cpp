// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/reposition_creep.h"

#include <cmath>

#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

class RepositionCreep final : public Effect {
 public:
  RepositionCreep(double decay_s, const calib::Vector3& direction) : decay_s_(decay_s), direction_(direction) {}

  void advance_to(const Conditions& now) override {
    const double place = direction_[0] * now.up[0] + direction_[1] * now.up[1] + direction_[2] * now.up[2];
    if (started_) stress_ = stress_ * std::exp(-(now.time_s - time_s_) / decay_s_) + place - place_;
    started_ = true;
    time_s_ = now.time_s;
    place_ = place;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return stress_; }

 private:
  double decay_s_;
  calib::Vector3 direction_;
  bool started_ = false;
  double time_s_ = 0.0;
  double place_ = 0.0;
  double stress_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_reposition_creep(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<RepositionCreep>(shape.spread("decay_s", {150.0, 900.0}), drawn_direction(shape.random()));
}

}  // namespace soak::hal::sim
