// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/telegraph_noise.h"

#include <cmath>

#include "base/random.h"

namespace soak::hal::sim {
namespace {

class TelegraphNoise final : public Effect {
 public:
  TelegraphNoise(double mean_stay_s, std::uint64_t seed) : mean_stay_s_(mean_stay_s), random_(seed) {}

  void advance_to(const Conditions& now) override {
    if (!started_) next_s_ = now.time_s + stay_s();
    started_ = true;
    while (next_s_ <= now.time_s) {
      state_ = -state_;
      next_s_ += stay_s();
    }
  }

  [[nodiscard]] double response(calib::Sensor) const override { return state_; }

 private:
  [[nodiscard]] double stay_s() { return -mean_stay_s_ * std::log(1.0 - random_.uniform()); }

  double mean_stay_s_;
  base::Random random_;
  bool started_ = false;
  double next_s_ = 0.0;
  double state_ = 1.0;
};

}  // namespace

std::unique_ptr<Effect> make_telegraph_noise(const EffectOrder& order, ShapeDraws& shape) {
  return std::make_unique<TelegraphNoise>(shape.spread("mean_stay_s", {600.0, 5000.0}), order.seed);
}

}  // namespace soak::hal::sim
