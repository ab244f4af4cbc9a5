// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/deploy/detail/interval.h"

namespace soak::calib::table {

/// Ranges that hold every value and every slope (per °C) of a curve over a stretch of temperature. Infinite or NaN
/// where no range can be given.
struct Enclosure {
  Interval value;
  Interval slope;
};

/// A stretch of temperature in °C on which a curve is smooth, and its enclosure on any part of the stretch.
struct Piece {
  double from_c = 0.0;
  double to_c = 0.0;
  std::function<Enclosure(Interval temp_c)> enclose;
};

/// The curve from from_c to to_c, held outside its own domain, in smooth pieces from left to right. Models must be such
/// that anfis::validate_curve() accepts.
[[nodiscard]] std::vector<Piece> pieces_of(const Curve& curve, double from_c, double to_c);

/// Enclosure of a model in °C over a part of its input's range.
[[nodiscard]] Enclosure enclose(const anfis::Model& model, Interval temp_c);

/// Enclosure of Σ_p c[p] d^p.
[[nodiscard]] Enclosure enclose(const std::array<double, 4>& c, Interval d);

}  // namespace soak::calib::table
