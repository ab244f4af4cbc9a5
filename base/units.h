// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace soak::base {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Standard gravity in m/s² (CGPM 1901): the meaning of "g" in every `_g` column.
inline constexpr double kStandardGravity_mps2 = 9.80665;

/// 0 °C in kelvin.
inline constexpr double kZeroCelsius_k = 273.15;

/// Rotation rate of the Earth in rad/s (WGS 84).
inline constexpr double kEarthRate_rps = 7.292115e-5;

}  // namespace soak::base
