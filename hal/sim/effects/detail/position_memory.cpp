// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/position_memory.h"

#include <algorithm>
#include <cmath>

#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

class PositionMemory final : public Effect {
 public:
  explicit PositionMemory(const calib::Vector3& direction) : direction_(direction) {}

  void advance_to(const Conditions& now) override {
    const double longest = std::max({std::abs(now.up[0]), std::abs(now.up[1]), std::abs(now.up[2])});
    if (longest < 1.0 - 1e-9 || now.up == resting_) return;  // on the way, or still there
    value_ = direction_[0] * resting_[0] + direction_[1] * resting_[1] + direction_[2] * resting_[2];
    resting_ = now.up;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return value_; }

 private:
  calib::Vector3 direction_;
  calib::Vector3 resting_{};
  double value_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_position_memory(const EffectOrder&, ShapeDraws& shape) {
  return std::make_unique<PositionMemory>(drawn_direction(shape.random()));
}

}  // namespace soak::hal::sim
