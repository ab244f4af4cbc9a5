// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/thermal_hysteresis.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace soak::hal::sim {
namespace {

class ThermalHysteresis final : public Effect {
 public:
  ThermalHysteresis(double widest_c, double slope_pk) : slope_pk_(slope_pk) {
    for (std::size_t i = 0; i < plays_.size(); ++i) {
      plays_[i].half_width_c = widest_c * static_cast<double>(i + 1) / static_cast<double>(plays_.size());
    }
  }

  void advance_to(const Conditions& now) override {
    temp_c_ = now.element_c;
    for (Play& play : plays_) {
      if (!started_) play.place_c = temp_c_;
      play.place_c = std::clamp(play.place_c, temp_c_ - play.half_width_c, temp_c_ + play.half_width_c);
    }
    started_ = true;
  }

  [[nodiscard]] double response(calib::Sensor) const override {
    double sum = 0.0;
    for (const Play& play : plays_) sum += (temp_c_ - play.place_c) / play.half_width_c;
    return sum / static_cast<double>(plays_.size()) * (1.0 + slope_pk_ * (temp_c_ - 25.0));
  }

 private:
  struct Play {
    double half_width_c = 1.0;
    double place_c = 0.0;
  };

  double slope_pk_;
  double temp_c_ = 0.0;
  bool started_ = false;
  std::array<Play, 8> plays_{};
};

}  // namespace

std::unique_ptr<Effect> make_thermal_hysteresis(const EffectOrder&, ShapeDraws& shape) {
  const double widest_c = shape.within("widest_c", {4.0, 16.0});
  return std::make_unique<ThermalHysteresis>(widest_c, shape.within("slope_pk", {-0.006, 0.006}));
}

}  // namespace soak::hal::sim
