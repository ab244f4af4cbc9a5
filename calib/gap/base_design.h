// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/observations.h"

namespace soak::calib::gap {

/// The saturated base of one sensor: what a thermal model without any missing effect could follow at best. Columns, one
/// row per observation: a free level per plateau temperature (joined by a natural cubic spline, as visits settle some
/// tenths of a kelvin apart); accelerometers with positions also a free scale error per plateau and two constant
/// off-axis terms; then one offset per run but the first.
struct BaseDesign {
  Eigen::MatrixXd columns;
  Eigen::Index levels = 0;   ///< the first so many columns are the levels of the bias
  Eigen::Index offsets = 0;  ///< the last so many columns are run offsets
};

/// `temp_c`: the temperature that the base is a function of, one per observation (the sensor's own thermometer, or what
/// an accepted term makes of it).
[[nodiscard]] BaseDesign base_design(const Observations& observations, Sensor sensor,
                                     const std::vector<double>& temp_c);

/// Slope against temperature of what `coefficients` of the base say, at each observation: per kelvin.
[[nodiscard]] Eigen::VectorXd base_slope(const Observations& observations, Sensor sensor,
                                         const std::vector<double>& temp_c, const Eigen::VectorXd& coefficients);

}  // namespace soak::calib::gap
