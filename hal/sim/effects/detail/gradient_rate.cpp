// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/gradient_rate.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class GradientRate final : public Effect {
 public:
  explicit GradientRate(double smoothing_s) : smoothing_s_(smoothing_s) {}

  // The difference less what follows it with the time constant is the smoothed rate times the time constant.
  void advance_to(const Conditions& now) override {
    const double gradient_c = now.air_c - now.thermometer_c;
    if (!started_) follower_c_ = gradient_c;
    const double stays = std::exp(-(now.time_s - time_s_) / smoothing_s_);
    if (started_) follower_c_ = gradient_c + (follower_c_ - gradient_c) * stays;
    started_ = true;
    time_s_ = now.time_s;
    rate_kpmin_ = (gradient_c - follower_c_) / (smoothing_s_ / 60.0);
  }

  [[nodiscard]] double response(calib::Sensor) const override { return rate_kpmin_; }

 private:
  double smoothing_s_;
  bool started_ = false;
  double time_s_ = 0.0;
  double follower_c_ = 0.0;
  double rate_kpmin_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_gradient_rate(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<GradientRate>(shape.spread("smoothing_s", {60.0, 240.0}));
}

}  // namespace soak::hal::sim
