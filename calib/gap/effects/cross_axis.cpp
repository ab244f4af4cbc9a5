// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

Effect cross_axis() {
  Effect effect;
  effect.name = "cross_axis";
  effect.physics = "the sensing axes turn in the package as it expands: misalignment that changes with temperature";
  effect.twins = {"fixture_tilt"};
  effect.experiment = "the unit remounted by 90 degrees: misalignment turns with it, a tilt of the fixture does not";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    if (!c.observations.has_positions()) return "one attitude only";
    if (c.observations.level_count() < 2) return "one temperature only";
    return std::nullopt;
  };
  effect.candidates = [](const Circumstances& c) {
    const Eigen::VectorXd z = reduced_temperature(c.observations);
    Candidate candidate;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Eigen::MatrixXd columns(z.size(), 2);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        const Observation& row = c.observations.rows[static_cast<std::size_t>(i)];
        const double g = c.observations.gravity_mps2;
        columns(i, 0) = z(i) * g * c.observations.force_g(row, (axis + 1) % 3);
        columns(i, 1) = z(i) * g * c.observations.force_g(row, (axis + 2) % 3);
      }
      candidate.columns[axis + 3] = columns;
    }
    return std::vector{std::move(candidate)};
  };
  effect.magnitude = [](const Circumstances& c, const Candidate&, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() / half_range_c(c.observations), "rad/K"};
  };
  effect.meaning = [](const Circumstances& c, const Candidate&, Sensor sensor) {
    const double per_c = 1.0 / half_range_c(c.observations);
    return Meaning{{{axis_name(axis_of(sensor) + 1), "1/K", per_c}, {axis_name(axis_of(sensor) + 2), "1/K", per_c}},
                   {{"reference_c", middle_c(c.observations), "degC"}}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
