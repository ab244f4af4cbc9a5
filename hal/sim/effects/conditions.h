// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "base/random.h"
#include "calib/vocabulary/position.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {

/// Unix time at which every simulated laboratory begins: 2026-01-01 09:00:00.
inline constexpr double kFirstUtc_s = 1767258000.0;

/// What surrounds and drives a unit at one moment. Times only rise from one moment to the next; from one pass through
/// the chamber to the next they may stand still or jump ahead.
struct Conditions {
  double time_s = 0.0;            ///< device time since the laboratory began
  double utc_s = 0.0;             ///< Unix time
  double since_power_on_s = 0.0;  ///< 0 while the unit has no power
  bool powered = false;
  int run = 0;                 ///< ordinal of the power-on, from 0
  int mounting = 0;            ///< ordinal of the mounting on the fixture, from 0
  double thermometer_c = 0.0;  ///< the unit where its thermometer is, without noise
  double element_c = 0.0;      ///< the sensing elements
  double air_c = 0.0;          ///< of the chamber
  calib::Vector3 up{};         ///< unit vector in body axes
  double compressor = 0.0;     ///< 1 while it runs, else 0
  double supply_v = 0.0;
};

/// The voltage that feeds the units: 5 V, an offset of its own after each power-on (0.03 V) and a slow wandering of
/// 0.02 V with a correlation time of 400 s. Depends on the seed and on the moments that it is asked for.
class SupplyVoltage {
 public:
  explicit SupplyVoltage(std::uint64_t seed) : seed_(seed) {}

  /// `run` is the ordinal of the power-on.
  [[nodiscard]] double at(double time_s, int run) {
    const double decay = moment_ == 0 ? 0.0 : std::exp(-(time_s - time_s_) / 400.0);
    const double innovation = base::hashed_gaussian(seed_, stream_of(Purpose::supply, 1), moment_++);
    wandering_ = decay * wandering_ + std::sqrt(1.0 - decay * decay) * innovation;
    time_s_ = time_s;
    const double offset = base::hashed_gaussian(seed_, stream_of(Purpose::supply, 0), static_cast<std::uint64_t>(run));
    return 5.0 + 0.03 * offset + 0.02 * wandering_;
  }

 private:
  std::uint64_t seed_;
  std::uint64_t moment_ = 0;
  double time_s_ = 0.0;
  double wandering_ = 0.0;  ///< of unit variance
};

}  // namespace soak::hal::sim
