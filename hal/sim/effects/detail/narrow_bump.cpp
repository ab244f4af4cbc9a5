// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/narrow_bump.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

class NarrowBump final : public Effect {
 public:
  NarrowBump(bool is_step, double centre_c, double half_width_c)
      : is_step_(is_step), centre_c_(centre_c), half_width_c_(half_width_c) {}

  void advance_to(const Conditions& now) override { distance_ = (now.element_c - centre_c_) / half_width_c_; }

  [[nodiscard]] double response(calib::Sensor) const override {
    return is_step_ ? 1.0 / (1.0 + std::exp(-distance_)) : 1.0 / (1.0 + distance_ * distance_);
  }

 private:
  bool is_step_;
  double centre_c_;
  double half_width_c_;
  double distance_ = 0.0;
};

/// Index of a set point that has `neighbours_above` more above it and one below it, where there are as many.
std::size_t inner_index(std::size_t count, std::size_t neighbours_above, base::Random& random) {
  const std::size_t choices = count > 1 + neighbours_above ? count - 1 - neighbours_above : 1;
  const auto chosen = static_cast<std::size_t>(random.uniform() * static_cast<double>(choices));
  return std::min(1 + chosen, count - 1);
}

}  // namespace

std::unique_ptr<Effect> make_narrow_bump(const EffectOrder& order, ShapeDraws& shape) {
  const std::vector<double>& points_c = order.set_points_c;
  const bool is_step = shape.toss("is_step");
  const std::size_t i = inner_index(points_c.size(), is_step ? 2 : 1, shape.random());
  const double next_c = points_c[std::min(i + 1, points_c.size() - 1)];
  const double centre_c = is_step ? points_c[i] + (next_c - points_c[i]) * shape.random().uniform(1.0 / 3.0, 2.0 / 3.0)
                                  : points_c[i] + shape.random().uniform(-3.0, 3.0);
  shape.kept("centre_c", centre_c);
  const double half_width_c = shape.within("half_width_c", is_step ? Range{0.3, 1.0} : Range{1.5, 4.0});
  return std::make_unique<NarrowBump>(is_step, centre_c, half_width_c);
}

}  // namespace soak::hal::sim
