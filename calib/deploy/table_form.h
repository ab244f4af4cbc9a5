// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::calib {

/// Points that a curve of the table form may have.
inline constexpr int kFewestTablePoints = 2;
inline constexpr int kMostTablePoints = 256;

/// The calibration with every curve as a table of at most `points` equally spaced points over its sensor's valid range
/// (a scale factor measured in a part of it: over that part, to 0.02 °C), linear between them: for small controllers.
/// TableCurve::bound says how far it is from the curve that it stands for. The bound is proven, not sampled
///. Curves that are tables of so few points already stay as they are. Refuses a number of
/// points outside 2 ... 256, and a curve for which there is no bound because its rules leave a gap, named by its
/// sensor.
[[nodiscard]] base::Result<Calibration> table_form(const Calibration& calibration, int points);

}  // namespace soak::calib
