// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/warmup_transient.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class WarmupTransient final : public Effect {
 public:
  WarmupTransient(double fast_s, double slow_s, double fast_share)
      : fast_s_(fast_s), slow_s_(slow_s), fast_share_(fast_share) {}

  void advance_to(const Conditions& now) override {
    const double t_s = now.since_power_on_s;
    value_ =
        now.powered ? fast_share_ * std::exp(-t_s / fast_s_) + (1.0 - fast_share_) * std::exp(-t_s / slow_s_) : 0.0;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return value_; }

 private:
  double fast_s_;
  double slow_s_;
  double fast_share_;
  double value_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_warmup_transient(const EffectOrder&, ShapeDraws& shape) {
  const double fast_s = shape.spread("fast_s", {150.0, 500.0});
  const double slow_s = shape.spread("slow_s", {1200.0, 5000.0});
  return std::make_unique<WarmupTransient>(fast_s, slow_s, shape.within("fast_share", {0.2, 0.6}));
}

}  // namespace soak::hal::sim
