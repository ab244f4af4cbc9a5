// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/effects/conditions.h"
#include "hal/sim/effects/drawn_effect.h"
#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// What effects are told about the laboratory.
struct EffectSurroundings {
  std::optional<EarthFrame> earth;
  std::vector<double> set_points_c;
  double amplitude_spread = 0.0;  ///< relative standard deviation of the strength from mounting to mounting
};

/// A hidden effect at work: a mechanism, its size, and its strength in the present mounting.
class ActiveEffect {
 public:
  ActiveEffect(const DrawnEffect& drawn, double amplitude, const EffectSurroundings& surroundings);

  /// Goes on to `now`; the elements become as warm as the effect makes them.
  void advance_to(Conditions& now);
  /// To be added to the reading, rad/s or m/s².
  [[nodiscard]] double addition(calib::Sensor sensor) const;
  [[nodiscard]] double noise_factor(calib::Sensor sensor) const;
  [[nodiscard]] double output(calib::Sensor sensor, double value) const;

  [[nodiscard]] const std::vector<ShapeParameter>& shape() const { return shape_; }
  /// What a mounting multiplies the amplitude by: 1 + spread · a Gaussian number, kept between 0.1 and 1.9.
  [[nodiscard]] double strength(int mounting) const;

 private:
  std::uint64_t seed_;
  double spread_;
  double strength_ = 1.0;
  std::array<double, calib::kSensorCount> gain_{};  ///< SI per unit of response
  std::vector<ShapeParameter> shape_;
  std::unique_ptr<Effect> effect_;
};

/// All hidden effects of one unit, in the loop that makes its readings: advance, ask for the temperature of the
/// elements, then for what each sensor feels and for its output word. Without effects everything stays as it is.
class HiddenEffects {
 public:
  HiddenEffects() = default;

  void add(const DrawnEffect& drawn, double amplitude, const EffectSurroundings& surroundings);

  /// `now.element_c` is ignored. Effects that warm or cool the elements come first, whatever the order of add().
  void advance_to(Conditions now);
  [[nodiscard]] double element_c() const { return element_c_; }
  /// What a sensor feels that would read `reading` without effects and noise.
  [[nodiscard]] double sensed(calib::Sensor sensor, double reading, double noise) const;
  /// What becomes of an output word.
  [[nodiscard]] double output(calib::Sensor sensor, double value) const;

  [[nodiscard]] bool empty() const { return effects_.empty(); }
  /// In the order of add().
  [[nodiscard]] const ActiveEffect& effect(std::size_t index) const { return *effects_[index]; }

 private:
  std::vector<std::unique_ptr<ActiveEffect>> effects_;
  std::vector<ActiveEffect*> order_;  ///< of the calls
  double element_c_ = 0.0;
};

}  // namespace soak::hal::sim
