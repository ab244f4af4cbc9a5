// SPDX-License-Identifier: Apache-2.0
// Effects that follow a temperature. catalogue.cpp says what each one is.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hal/sim/effects/detail/effect_makers.h"

namespace soak::hal::sim {
namespace {

constexpr double kTrendReference_c = 25.0;

/// T_element = T − behind, d(behind)/dt = dT/dt − behind/τ.
class SensorLag final : public Effect {
 public:
  explicit SensorLag(double tau_s) : tau_s_(tau_s) {}

  // Exact where the thermometer moves in a straight line from one moment to the next.
  void advance_to(const Conditions& now) override {
    const auto passed_s = clock_.lap_s(now.time_s);
    if (passed_s && *passed_s > 0.0 && tau_s_ > 0.0) {
      const double slope_kps = (now.thermometer_c - temp_c_) / *passed_s;
      const double settled_c = slope_kps * tau_s_;
      behind_c_ = settled_c + (behind_c_ - settled_c) * std::exp(-*passed_s / tau_s_);
    }
    temp_c_ = now.thermometer_c;
  }

  [[nodiscard]] double element_shift_c() const override { return -behind_c_; }

 private:
  double tau_s_;
  Stopwatch clock_;
  double temp_c_ = 0.0;
  double behind_c_ = 0.0;
};

/// Play operators of half-widths w, 2w, ... 8w: each place moves only when the temperature has used up its play.
struct Plays {
  std::array<double, 8> half_width_c{};
  std::array<double, 8> place_c{};
  bool started = false;

  /// Mean of what the places stay behind, each relative to its half-width.
  [[nodiscard]] double follow(double temp_c) {
    if (!started) place_c.fill(temp_c);
    started = true;
    double sum = 0.0;
    for (std::size_t i = 0; i < place_c.size(); ++i) {
      place_c[i] = std::clamp(place_c[i], temp_c - half_width_c[i], temp_c + half_width_c[i]);
      sum += (temp_c - place_c[i]) / half_width_c[i];
    }
    return sum / static_cast<double>(place_c.size());
  }
};

/// Index of a set point that has `neighbours_above` more above it and one below it, where there are as many.
std::size_t inner_index(std::size_t count, std::size_t neighbours_above, base::Random& random) {
  const std::size_t choices = count > 1 + neighbours_above ? count - 1 - neighbours_above : 1;
  const auto chosen = static_cast<std::size_t>(random.uniform() * static_cast<double>(choices));
  return std::min(1 + chosen, count - 1);
}

}  // namespace

std::unique_ptr<Effect> make_thermal_hysteresis(const EffectOrder&, ShapeDraws& shape) {
  Plays plays;
  const double widest_c = shape.within("widest_c", {4.0, 16.0});
  const double slope_pk = shape.within("slope_pk", {-0.006, 0.006});
  for (std::size_t i = 0; i < plays.half_width_c.size(); ++i) {
    plays.half_width_c[i] = widest_c * static_cast<double>(i + 1) / static_cast<double>(plays.half_width_c.size());
  }
  return shared_response([plays, slope_pk](const Conditions& now) mutable {
    return plays.follow(now.element_c) * (1.0 + slope_pk * (now.element_c - kTrendReference_c));
  });
}

std::unique_ptr<Effect> make_temperature_rate(const EffectOrder&, ShapeDraws& shape) {
  const double slope_pk = shape.within("slope_pk", {-0.006, 0.006});
  return shared_response([=, clock = Stopwatch(), temp_c = 0.0, rate_kpmin = 0.0](const Conditions& now) mutable {
    const auto passed_s = clock.lap_s(now.time_s);
    if (passed_s && *passed_s > 0.0) rate_kpmin = (now.thermometer_c - temp_c) / (*passed_s / 60.0);
    temp_c = now.thermometer_c;
    return rate_kpmin * (1.0 + slope_pk * (temp_c - kTrendReference_c));
  });
}

std::unique_ptr<Effect> make_gradient_rate(const EffectOrder&, ShapeDraws& shape) {
  const double smoothing_s = shape.spread("smoothing_s", {60.0, 240.0});
  // The difference less what follows it with the time constant is the smoothed rate times the time constant.
  return shared_response([=, clock = Stopwatch(), follower_c = 0.0](const Conditions& now) mutable {
    const double gradient_c = now.air_c - now.thermometer_c;
    const auto passed_s = clock.lap_s(now.time_s);
    follower_c = passed_s ? gradient_c + (follower_c - gradient_c) * std::exp(-*passed_s / smoothing_s) : gradient_c;
    return (gradient_c - follower_c) / (smoothing_s / 60.0);
  });
}

std::unique_ptr<Effect> make_sensor_lag(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<SensorLag>(order.amplitude);
}

std::unique_ptr<Effect> make_narrow_bump(const EffectOrder& order, ShapeDraws& shape) {
  const std::vector<double>& points_c = order.set_points_c;
  const bool is_step = shape.toss("is_step");
  // A bump lies within 3 °C of a set point that is neither the first nor the last, a step between two of them.
  const std::size_t i = inner_index(points_c.size(), is_step ? 2 : 1, shape.random());
  const double next_c = points_c[std::min(i + 1, points_c.size() - 1)];
  const double centre_c = is_step ? points_c[i] + (next_c - points_c[i]) * shape.random().uniform(1.0 / 3.0, 2.0 / 3.0)
                                  : points_c[i] + shape.random().uniform(-3.0, 3.0);
  shape.kept("centre_c", centre_c);
  const double half_width_c = shape.within("half_width_c", is_step ? Range{0.3, 1.0} : Range{1.5, 4.0});
  // z = (T − T₀)/w: 1/(1 + z²) or 1/(1 + e^−z)
  return shared_response([=](const Conditions& now) {
    const double z = (now.element_c - centre_c) / half_width_c;
    return is_step ? 1.0 / (1.0 + std::exp(-z)) : 1.0 / (1.0 + z * z);
  });
}

std::unique_ptr<Effect> make_moisture(const EffectOrder&, ShapeDraws& shape) {
  const double uptake_ps = 1.0 / (3600.0 * shape.spread("uptake_h", {4.0, 20.0}));
  const double drying_50c_ps = 1.0 / (3600.0 * shape.spread("drying_h", {0.5, 3.0}));
  // dm/dt = (1 − m)/τ_up − m/τ_dry · 2^((T − 50 °C)/12), starting full. Exact where the temperature stands still from
  // one moment to the next.
  return shared_response([=, clock = Stopwatch(), content = 1.0](const Conditions& now) mutable {
    const double total_ps = uptake_ps + drying_50c_ps * std::exp2((now.element_c - 50.0) / 12.0);
    const double settled = uptake_ps / total_ps;
    const auto passed_s = clock.lap_s(now.time_s);
    if (passed_s) content = settled + (content - settled) * std::exp(-*passed_s * total_ps);
    return content;
  });
}

}  // namespace soak::hal::sim
