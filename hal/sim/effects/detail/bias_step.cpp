// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/bias_step.h"

#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

class BiasStep final : public Effect {
 public:
  BiasStep(double mean_wait_s, std::uint64_t seed) : mean_wait_s_(mean_wait_s), seed_(seed) {}

  void advance_to(const Conditions& now) override {
    if (!now.powered) {
      value_ = 0.0;
      return;
    }
    base::Random random(seed_, static_cast<std::uint64_t>(now.run));
    const double wait_s = -mean_wait_s_ * std::log(1.0 - random.uniform());
    const double height = drawn_sign(random) * random.uniform(0.5, 1.0);
    value_ = now.since_power_on_s >= wait_s ? height : 0.0;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return value_; }

 private:
  double mean_wait_s_;
  std::uint64_t seed_;
  double value_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_bias_step(const EffectOrder& order, ShapeDraws& shape) {
  return std::make_unique<BiasStep>(shape.spread("mean_wait_s", {5000.0, 15000.0}), order.seed);
}

}  // namespace soak::hal::sim
