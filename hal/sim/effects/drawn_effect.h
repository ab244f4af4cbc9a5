// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/hidden_config.h"
#include "hal/sim/effects/catalogue.h"

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

}  // namespace soak::hal::sim
