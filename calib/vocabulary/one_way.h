// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "calib/vocabulary/run.h"

/// Temperatures that were visited while heating only, or while cooling only: there a curve is one branch of the unit's
/// thermal hysteresis, and nothing in the readings says how far the other is.
namespace soak::calib {

/// A range of temperatures that was visited one way only.
struct OneWayRange {
  double low_c = 0.0;
  double high_c = 0.0;           ///< at least low_c
  Sweep sweep = Sweep::unknown;  ///< the way that was recorded: up or down

  bool operator==(const OneWayRange&) const = default;
};

/// Where a known hysteresis comes from. The value is its number in the calibration file (docs/blob-format.md 0x0015).
enum class HysteresisSource : std::uint8_t { none, type, fleet };

constexpr std::string_view name_of(HysteresisSource source) {
  return source == HysteresisSource::type ? "type" : source == HysteresisSource::fleet ? "fleet" : "none";
}

/// Half the gap between heating and cooling of a sensor's bias at the same temperature, from elsewhere than its own
/// runs.
struct KnownHysteresis {
  double half_gap = 0.0;  ///< rad/s, m/s²; at least 0
  HysteresisSource source = HysteresisSource::none;

  bool operator==(const KnownHysteresis&) const = default;
};

/// Ranges that were visited one way only, and what the bands hold of hysteresis there: nothing where the source is
/// none.
struct OneWay {
  std::vector<OneWayRange> ranges;  ///< rising, apart from each other; empty: none
  KnownHysteresis known;

  bool operator==(const OneWay&) const = default;
};

}  // namespace soak::calib
