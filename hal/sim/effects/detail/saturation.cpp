// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/saturation.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

class Saturation final : public Effect {
 public:
  explicit Saturation(const EffectOrder& order) : rail_(order.gain) {}

  void advance_to(const Conditions&) override {}

  [[nodiscard]] double output(calib::Sensor sensor, double value) const override {
    const double rail = std::abs(rail_[calib::index_of(sensor)]);
    return rail > 0.0 ? std::clamp(value, -rail, rail) : value;
  }

 private:
  std::array<double, calib::kSensorCount> rail_;
};

}  // namespace

std::unique_ptr<Effect> make_saturation(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<Saturation>(order);
}

}  // namespace soak::hal::sim
