// SPDX-License-Identifier: Apache-2.0
// Effects of electronics and output words, and those that only time decides. catalogue.cpp says what each one is.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.h"
#include "hal/sim/effects/detail/effect_makers.h"
#include "hal/sim/unit/draws.h"

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

/// What becomes of an output word, by the size of the sensor's amplitude.
template <class WordOf>
std::unique_ptr<Effect> output_word(const EffectOrder& order, WordOf word_of) {
  class OutputWord final : public Effect {
   public:
    OutputWord(const EffectOrder& made_from, WordOf of) : gain_(made_from.gain), word_of_(of) {}
    void advance_to(const Conditions&) override {}
    [[nodiscard]] double output(calib::Sensor sensor, double value) const override {
      const double size = std::abs(gain_[calib::index_of(sensor)]);
      return size > 0.0 ? word_of_(value, size) : value;
    }

   private:
    std::array<double, calib::kSensorCount> gain_;
    WordOf word_of_;
  };
  return std::make_unique<OutputWord>(order, word_of);
}

/// A waiting time of exponential distribution.
double drawn_wait_s(double mean_s, base::Random& random) { return -mean_s * std::log(1.0 - random.uniform()); }

}  // namespace

std::unique_ptr<Effect> make_warmup_transient(const EffectOrder&, ShapeDraws& shape) {
  const double fast_s = shape.spread("fast_s", {150.0, 500.0});
  const double slow_s = shape.spread("slow_s", {1200.0, 5000.0});
  const double share = shape.within("fast_share", {0.2, 0.6});
  // s·e^(−t/τ_fast) + (1 − s)·e^(−t/τ_slow)
  return shared_response([=](const Conditions& now) {
    const double t_s = now.since_power_on_s;
    return now.powered ? share * std::exp(-t_s / fast_s) + (1.0 - share) * std::exp(-t_s / slow_s) : 0.0;
  });
}

std::unique_ptr<Effect> make_supply_sensitivity(const EffectOrder&, ShapeDraws&) {
  return shared_response([](const Conditions& now) { return now.supply_v - 5.0; });
}

std::unique_ptr<Effect> make_vibration_rectification(const EffectOrder&, ShapeDraws& shape) {
  const double spin_up_s = shape.within("spin_up_s", {1.0, 8.0});
  return shared_response([=, clock = Stopwatch(), level = 0.0](const Conditions& now) mutable {
    const auto passed_s = clock.lap_s(now.time_s);
    const double stays = passed_s ? std::exp(-*passed_s / spin_up_s) : 0.0;
    level = now.compressor + (level - now.compressor) * stays;
    return level * level;
  });
}

std::unique_ptr<Effect> make_aging_drift(const EffectOrder&, ShapeDraws&) {
  return shared_response([first_utc_s = std::optional<double>()](const Conditions& now) mutable {
    if (!first_utc_s) first_utc_s = now.utc_s;
    return (now.utc_s - *first_utc_s) / 3.6e6;
  });
}

std::unique_ptr<Effect> make_daily_wave(const EffectOrder&, ShapeDraws& shape) {
  const double peak_hour = shape.within("peak_hour", {0.0, 24.0});
  return shared_response([=](const Conditions& now) {
    return std::cos(2.0 * std::numbers::pi * (now.utc_s / 3600.0 - peak_hour) / 24.0);
  });
}

std::unique_ptr<Effect> make_telegraph_noise(const EffectOrder& order, ShapeDraws& shape) {
  const double mean_stay_s = shape.spread("mean_stay_s", {600.0, 5000.0});
  return shared_response([=, random = base::Random(order.seed), next_s = std::optional<double>(),
                          state = 1.0](const Conditions& now) mutable {
    if (!next_s) next_s = now.time_s + drawn_wait_s(mean_stay_s, random);
    for (; *next_s <= now.time_s; *next_s += drawn_wait_s(mean_stay_s, random)) state = -state;
    return state;
  });
}

std::unique_ptr<Effect> make_bias_step(const EffectOrder& order, ShapeDraws& shape) {
  const double mean_wait_s = shape.spread("mean_wait_s", {5000.0, 15000.0});
  return shared_response([=, seed = order.seed](const Conditions& now) {
    if (!now.powered) return 0.0;
    base::Random random(seed, static_cast<std::uint64_t>(now.run));
    const double wait_s = drawn_wait_s(mean_wait_s, random);
    const double height = drawn_sign(random) * random.uniform(0.5, 1.0);
    return now.since_power_on_s >= wait_s ? height : 0.0;
  });
}

std::unique_ptr<Effect> make_noise_vs_temperature(const EffectOrder& order, ShapeDraws&) {
  return std::make_unique<NoiseVsTemperature>(order.amplitude);
}

std::unique_ptr<Effect> make_quantization(const EffectOrder& order, ShapeDraws&) {
  return output_word(order, [](double value, double step) { return step * std::round(value / step); });
}

std::unique_ptr<Effect> make_saturation(const EffectOrder& order, ShapeDraws&) {
  return output_word(order, [](double value, double rail) { return std::clamp(value, -rail, rail); });
}

}  // namespace soak::hal::sim
