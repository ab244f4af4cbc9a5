// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/config/hidden_config.h"
#include "hal/sim/effects/catalogue.h"
#include "hal/sim/effects/conditions.h"
#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// What chance decides of a hidden effect of one unit before its size is known.
struct DrawnEffect {
  const CatalogueEntry* entry = nullptr;
  std::uint64_t seed = 0;                            ///< of shape and chance
  std::vector<calib::Sensor> sensors;                ///< that are hit, in the order of calib::kSensors
  std::array<double, calib::kSensorCount> weight{};  ///< of the amplitude; 0 where a sensor is not hit
};

/// The effect that `spec` hides in the `number`-th unit. Sensors that `spec` does not name are drawn: of those that may
/// be hit one, three of a kind or all. Where the magnitude is given and the entry says so, the weights are of random
/// sign and between 0.5 and 1, the largest 1; else 1. Beside gyros the weight of an accelerometer is also multiplied by
/// `mps2_per_dps`, so that both kinds are hit equally hard.
[[nodiscard]] DrawnEffect draw_effect(const HiddenSpec& spec, int number, double mps2_per_dps);

/// Amplitude of a sensor that an effect hits, in printed units, where the amplitude of the effect is `amplitude`: that
/// of its gyros or, without gyros, of its accelerometers.
[[nodiscard]] double amplitude_of(const DrawnEffect& drawn, calib::Sensor sensor, double amplitude);

/// What effects are told about the laboratory.
struct EffectSurroundings {
  std::optional<EarthFrame> earth;
  std::vector<double> set_points_c;
  double amplitude_spread = 0.0;  ///< relative standard deviation of the strength from mounting to mounting
};

/// A hidden effect at work: an effect, its size, and its strength in the present mounting.
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

/// A hidden effect of a unit in the laboratory of soaksim.
struct LabEffect {
  DrawnEffect drawn;
  double amplitude = 0.0;
};

/// What [[hidden]] does to the `number`-th unit of soaksim. Every effect must state its amplitude.
[[nodiscard]] std::vector<LabEffect> lab_effects(const CampaignConfig& config, int number);

/// What effects are told about the laboratory: its set points are those of [campaign].
[[nodiscard]] EffectSurroundings lab_surroundings(const CampaignConfig& config);

/// JSON object {name: value} of a shape.
[[nodiscard]] std::string shape_json(const std::vector<ShapeParameter>& shape);

}  // namespace soak::hal::sim
