// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/moisture.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class Moisture final : public Effect {
 public:
  Moisture(double uptake_s, double drying_s) : uptake_ps_(1.0 / uptake_s), drying_ps_(1.0 / drying_s) {}

  // Exact where the temperature stands still from one moment to the next.
  void advance_to(const Conditions& now) override {
    const double drying_ps = drying_ps_ * std::exp2((now.element_c - 50.0) / 12.0);
    const double total_ps = uptake_ps_ + drying_ps;
    const double settled = uptake_ps_ / total_ps;
    if (started_) content_ = settled + (content_ - settled) * std::exp(-(now.time_s - time_s_) * total_ps);
    started_ = true;
    time_s_ = now.time_s;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return content_; }

 private:
  double uptake_ps_;
  double drying_ps_;
  bool started_ = false;
  double time_s_ = 0.0;
  double content_ = 1.0;
};

}  // namespace

std::unique_ptr<Effect> make_moisture(const EffectOrder&, ShapeDraws& shape) {
  const double uptake_h = shape.spread("uptake_h", {4.0, 20.0});
  return std::make_unique<Moisture>(3600.0 * uptake_h, 3600.0 * shape.spread("drying_h", {0.5, 3.0}));
}

}  // namespace soak::hal::sim
