// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/estimate/gravity.h"
#include "calib/estimate/type_b_input.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/sensor.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::calib {

/// What is known of the circumstances under which a sensor was measured, beyond its readings.
struct Circumstances {
  Gravity gravity;
  std::optional<double> latitude_deg;
  std::optional<double> thermometer_repeatability_c;  ///< UnitType
  std::optional<double> thermometer_lsb_c;
  std::vector<ReferenceUse> references;
  bool positions = true;  ///< false: one attitude throughout
};

/// Standard uncertainty of the fixture's faces about each axis, rad. Absent where the register has no squareness.
[[nodiscard]] std::optional<double> face_uncertainty_rad(const Circumstances& circumstances);

/// Standard uncertainty of the direction of gravity in the unit's frame, rad: faces of the fixture and its level, each
/// about two axes. Absent where the register has no squareness.
[[nodiscard]] std::optional<double> attitude_uncertainty_rad(const Circumstances& circumstances);

/// Rotation of the Earth across the vertical, rad/s; all of it where nobody knows the latitude.
[[nodiscard]] double horizontal_earth_rate_rps(const Circumstances& circumstances);

/// Thermometer, gravity and fixture, in this order, for the bias curve of a sensor in SI.
///
/// With the axis' own up/down pair, bias = (up + down)/2: gravity cancels, and tilts ε of the two faces enter an
/// accelerometer by g(cos ε₊ − cos ε₋)/2, of standard deviation g u²/√2, a gyro by the part of the Earth's rotation and
/// of the cross g-sensitivity that they turn into its axis, Ω cos φ u/√2 and g |G⊥| u/√2. `turned`: the pair exists.
/// `cross_g_sensitivity`: |G⊥| in (rad/s)/(m/s²) without the Earth's rotation, 0 for accelerometers.
[[nodiscard]] std::vector<TypeBInput> bias_inputs(const Circumstances& circumstances, Sensor sensor, bool turned,
                                                  double cross_g_sensitivity);

/// The same for the scale curve in ppm. Accelerometer: u(g)/g, and (cos ε₊ + cos ε₋)/2 − 1, of root mean square
/// u²√(3/2). Gyro: the rate of the fixture.
[[nodiscard]] std::vector<TypeBInput> scale_inputs(const Circumstances& circumstances, Sensor sensor);

}  // namespace soak::calib
