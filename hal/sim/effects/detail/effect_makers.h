// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

using EffectFunction = std::unique_ptr<Effect>(const EffectOrder& order, ShapeDraws& shape);

// thermal.cpp
EffectFunction make_thermal_hysteresis;
EffectFunction make_temperature_rate;
EffectFunction make_gradient_rate;
EffectFunction make_sensor_lag;
EffectFunction make_narrow_bump;
EffectFunction make_moisture;
// attitude.cpp
EffectFunction make_g_sensitivity;
EffectFunction make_earth_rate;
EffectFunction make_cross_axis;
EffectFunction make_fixture_tilt;
EffectFunction make_scale_nonlinearity;
EffectFunction make_reposition_creep;
EffectFunction make_position_memory;
// electrical.cpp
EffectFunction make_warmup_transient;
EffectFunction make_supply_sensitivity;
EffectFunction make_vibration_rectification;
EffectFunction make_aging_drift;
EffectFunction make_daily_wave;
EffectFunction make_telegraph_noise;
EffectFunction make_bias_step;
EffectFunction make_noise_vs_temperature;
EffectFunction make_quantization;
EffectFunction make_saturation;

/// Time from one moment to the next.
class Stopwatch {
 public:
  /// Seconds since the last call; nothing at the first one.
  [[nodiscard]] std::optional<double> lap_s(double time_s) {
    const std::optional<double> before = std::exchange(last_s_, time_s);
    return before ? std::optional(time_s - *before) : std::nullopt;
  }

 private:
  std::optional<double> last_s_;
};

/// An effect whose response is the same for all sensors: `response_at` is asked once for each moment, in order of
/// time, so that it may keep what it remembers in its captures.
template <class ResponseAt>
[[nodiscard]] std::unique_ptr<Effect> shared_response(ResponseAt response_at) {
  class SharedResponse final : public Effect {
   public:
    explicit SharedResponse(ResponseAt at) : at_(std::move(at)) {}
    void advance_to(const Conditions& now) override { value_ = at_(now); }
    [[nodiscard]] double response(calib::Sensor) const override { return value_; }

   private:
    ResponseAt at_;
    double value_ = 0.0;
  };
  return std::make_unique<SharedResponse>(std::move(response_at));
}

enum class SensorKind { gyros, accels };

/// An effect that hits one kind of sensor: `response_at` gives the responses of its three axes as a vector.
template <class ResponseAt>
[[nodiscard]] std::unique_ptr<Effect> axis_response(SensorKind kind, ResponseAt response_at) {
  class AxisResponse final : public Effect {
   public:
    AxisResponse(bool gyros, ResponseAt at) : gyros_(gyros), at_(std::move(at)) {}
    void advance_to(const Conditions& now) override { value_ = at_(now); }
    [[nodiscard]] double response(calib::Sensor sensor) const override {
      return calib::is_gyro(sensor) == gyros_ ? value_[calib::axis_of(sensor)] : 0.0;
    }

   private:
    bool gyros_;
    ResponseAt at_;
    calib::Vector3 value_{};
  };
  return std::make_unique<AxisResponse>(kind == SensorKind::gyros, std::move(response_at));
}

}  // namespace soak::hal::sim
