// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/quantization.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class Quantization final : public Effect {
 public:
  explicit Quantization(const EffectOrder& order) : step_(order.gain) {}

  void advance_to(const Conditions&) override {}

  [[nodiscard]] double output(calib::Sensor sensor, double value) const override {
    const double step = std::abs(step_[calib::index_of(sensor)]);
    return step > 0.0 ? step * std::round(value / step) : value;
  }

 private:
  std::array<double, calib::kSensorCount> step_;
};

}  // namespace

std::unique_ptr<Effect> make_quantization(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<Quantization>(order);
}

}  // namespace soak::hal::sim
