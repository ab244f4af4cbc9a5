// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/curve/calibration.h"

namespace soak::calib::file {

/// The curve as a cubic spline from temp_min_c to temp_max_c that differs by less than 1e-7 of `span`: for models whose
/// own form float32 cannot hold. Each piece is the cubic through four points of the curve; pieces are halved where the
/// curve is steep. Nothing if the file's limit of pieces does not suffice.
[[nodiscard]] std::optional<SplineCurve> spline_form(const Curve& curve, double temp_min_c, double temp_max_c,
                                                     double span);

}  // namespace soak::calib::file
