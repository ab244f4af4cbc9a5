// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/supply_sensitivity.h"

namespace soak::hal::sim {
namespace {

class SupplySensitivity final : public Effect {
 public:
  void advance_to(const Conditions& now) override { excess_v_ = now.supply_v - 5.0; }

  [[nodiscard]] double response(calib::Sensor) const override { return excess_v_; }

 private:
  double excess_v_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_supply_sensitivity(const EffectOrder&, ShapeDraws&) {
  return std::make_unique<SupplySensitivity>();
}

}  // namespace soak::hal::sim
