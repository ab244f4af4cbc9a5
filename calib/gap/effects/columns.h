// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "calib/gap/effects/effect.h"

namespace soak::calib::gap {

/// Temperature of each observation about the middle of the campaign's range, −1 to 1 over it.
[[nodiscard]] Eigen::VectorXd reduced_temperature(const Observations& observations);
/// Half the campaign's range of temperature, kelvin; 1 with a single level.
[[nodiscard]] double half_range_c(const Observations& observations);

[[nodiscard]] Eigen::VectorXd as_vector(const std::vector<double>& values);
/// `column` and `column` times the reduced temperature, side by side.
[[nodiscard]] Eigen::MatrixXd with_temperature_shape(const Observations& observations, const Eigen::VectorXd& column);

/// The same columns for all sensors, for the gyros, for the accelerometers.
void set_all(Candidate& candidate, const Eigen::MatrixXd& columns);
void set_gyros(Candidate& candidate, const Eigen::MatrixXd& columns);
void set_accelerometers(Candidate& candidate, const Eigen::MatrixXd& columns);

/// The candidates of each value of the shape, side by side.
template <class Grid, class OfShape>
[[nodiscard]] std::vector<Candidate> over_grid(const Circumstances& circumstances, const Grid& grid, OfShape of_shape) {
  std::vector<Candidate> list;
  for (const double value : grid) {
    for (Candidate& candidate : of_shape(circumstances, value)) list.push_back(std::move(candidate));
  }
  return list;
}

/// Magnitude of a linear term with one parameter (the first): printed unit, then `per` ("/V").
[[nodiscard]] Magnitude linear_magnitude(Sensor sensor, const Eigen::VectorXd& parameters, double factor,
                                         std::string_view per);

}  // namespace soak::calib::gap
