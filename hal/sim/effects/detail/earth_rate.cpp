// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/earth_rate.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {
namespace {

class EarthRate final : public Effect {
 public:
  explicit EarthRate(const EarthFrame& frame) : frame_(frame) {}

  void advance_to(const Conditions& now) override {
    const calib::Vector3& up = now.up;
    const double largest = std::max({std::abs(up[0]), std::abs(up[1]), std::abs(up[2])});
    if (largest > 1.0 - 1e-9) {
      calib::Position position;
      position.up = up;
      rate_ = resting(position, frame_).rate_rps;
      for (double& part : rate_) part /= base::kEarthRate_rps;
      return;
    }
    const double vertical = std::sin(frame_.latitude_deg * base::kRadPerDeg);
    rate_ = {vertical * up[0], vertical * up[1], vertical * up[2]};
  }

  [[nodiscard]] double response(calib::Sensor sensor) const override {
    return calib::is_gyro(sensor) ? rate_[calib::axis_of(sensor)] : 0.0;
  }

 private:
  EarthFrame frame_;
  calib::Vector3 rate_{};  ///< in rates of the Earth
};

}  // namespace

std::unique_ptr<Effect> make_earth_rate(const EffectOrder& order, ShapeDraws& shape) {
  EarthFrame frame;
  if (order.earth) {
    frame.latitude_deg = shape.kept("latitude_deg", order.earth->latitude_deg);
    frame.azimuth_deg = shape.kept("azimuth_deg", order.earth->azimuth_deg);
  } else {
    frame.latitude_deg = shape.within("latitude_deg", {25.0, 65.0});
    frame.azimuth_deg = shape.within("azimuth_deg", {0.0, 360.0});
  }
  return std::make_unique<EarthRate>(frame);
}

}  // namespace soak::hal::sim
