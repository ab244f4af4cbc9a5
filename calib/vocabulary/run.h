// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace soak::calib {

enum class Phase : std::uint8_t { soak, ramp };

/// Sign of the last change of the set point; a turning plateau keeps its arrival direction.
enum class Sweep : std::uint8_t { unknown, up, down };

constexpr std::string_view name_of(Sweep sweep) {
  return sweep == Sweep::up ? "up" : sweep == Sweep::down ? "down" : "unknown";
}

constexpr Sweep sweep_named(std::string_view name) {
  return name == "up" ? Sweep::up : name == "down" ? Sweep::down : Sweep::unknown;
}

/// Where and how the units stood: what is known of gravity and the Earth's rotation at the place.
struct Site {
  std::optional<double> latitude_deg;  ///< north positive
  std::optional<double> height_m;
  std::optional<double>
      azimuth_deg;  ///< heading of the fixture, clockwise from true north; Position::azimuth_deg adds to it
  std::optional<double> gravity_mps2;

  bool operator==(const Site&) const = default;
};

}  // namespace soak::calib
