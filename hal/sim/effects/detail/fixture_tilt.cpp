// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/fixture_tilt.h"

#include <cmath>

#include "base/random.h"
#include "base/units.h"

namespace soak::hal::sim {
namespace {

class FixtureTilt final : public Effect {
 public:
  explicit FixtureTilt(std::uint64_t seed) : seed_(seed) {}

  void advance_to(const Conditions& now) override {
    up_ = now.up;
    const auto mounting = static_cast<std::uint64_t>(now.mounting);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      tilt_[axis] = base::hashed_gaussian(seed_, mounting, axis) / std::sqrt(3.0);
    }
  }

  [[nodiscard]] double response(calib::Sensor sensor) const override {
    if (calib::is_gyro(sensor)) return 0.0;
    const std::size_t a = calib::axis_of(sensor);
    const std::size_t b = (a + 1) % 3;
    const std::size_t c = (a + 2) % 3;
    return base::kRadPerDeg * base::kStandardGravity_mps2 * (tilt_[b] * up_[c] - tilt_[c] * up_[b]);
  }

 private:
  std::uint64_t seed_;
  calib::Vector3 up_{};
  calib::Vector3 tilt_{};
};

}  // namespace

std::unique_ptr<Effect> make_fixture_tilt(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<FixtureTilt>(order.seed);
}

}  // namespace soak::hal::sim
