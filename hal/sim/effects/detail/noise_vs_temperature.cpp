// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/noise_vs_temperature.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

class NoiseVsTemperature final : public Effect {
 public:
  explicit NoiseVsTemperature(double growth_pk) : growth_pk_(growth_pk) {}

  void advance_to(const Conditions& now) override { factor_ = std::exp(growth_pk_ * (now.element_c - 25.0)); }

  [[nodiscard]] double noise_factor() const override { return factor_; }

 private:
  double growth_pk_;
  double factor_ = 1.0;
};

}  // namespace

std::unique_ptr<Effect> make_noise_vs_temperature(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<NoiseVsTemperature>(order.amplitude);
}

}  // namespace soak::hal::sim
