// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

using MechanismMaker = std::unique_ptr<Effect>(const EffectOrder& order, ShapeDraws& shape);

// thermal.cpp
MechanismMaker make_thermal_hysteresis;
MechanismMaker make_temperature_rate;
MechanismMaker make_gradient_rate;
MechanismMaker make_sensor_lag;
MechanismMaker make_narrow_bump;
MechanismMaker make_moisture;
// attitude.cpp
MechanismMaker make_g_sensitivity;
MechanismMaker make_earth_rate;
MechanismMaker make_cross_axis;
MechanismMaker make_fixture_tilt;
MechanismMaker make_scale_nonlinearity;
MechanismMaker make_reposition_creep;
MechanismMaker make_position_memory;
// electrical.cpp
MechanismMaker make_warmup_transient;
MechanismMaker make_supply_sensitivity;
MechanismMaker make_vibration_rectification;
MechanismMaker make_aging_drift;
MechanismMaker make_daily_wave;
MechanismMaker make_telegraph_noise;
MechanismMaker make_bias_step;
MechanismMaker make_noise_vs_temperature;
MechanismMaker make_quantization;
MechanismMaker make_saturation;

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

/// A mechanism whose response is the same for all sensors: `response_at` is asked once for each moment, in order of
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

/// A mechanism that hits one kind of sensor: `response_at` gives the responses of its three axes as a vector.
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
