// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/detail/section.h"

namespace soak::calib::file {

/// Centre and half range that a curve's values are scaled by in the file; both are float32 numbers, half_range > 0.
struct OutputScale {
  double centre = 0.0;
  double half_range = 1.0;
};

/// Whether the curve can be evaluated and lies within the format's limits; of models the format carries those that
/// anfis::validate_curve() accepts: one input, one bell or Gaussian per rule. `where` names the curve.
[[nodiscard]] base::Status check_curve(const Curve& curve, const std::string& where);

/// The section of a curve that check_curve() accepts. What rounding `scale` and the FIS' centres to float32 would cost
/// is put into the other numbers, so that only their own rounding remains. Refuses numbers beyond float32 and knots
/// that coincide there.
[[nodiscard]] base::Result<Section> curve_section(Sensor sensor, Quantity quantity, const Curve& curve,
                                                  const OutputScale& scale);

/// What a table that stands for another curve says of its difference from it (docs/blob-format.md 0x0031); nothing for
/// all other curves. Rounded up.
[[nodiscard]] std::optional<Section> table_bound_section(Sensor sensor, Quantity quantity, const Curve& curve);

/// The curve in a payload that soak_load() has accepted; `type` is its section's.
[[nodiscard]] Curve read_curve(std::uint32_t type, const std::uint8_t* payload);

}  // namespace soak::calib::file
