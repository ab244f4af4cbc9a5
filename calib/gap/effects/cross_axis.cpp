// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

Effect cross_axis() {
  Effect effect;
  effect.name = "cross_axis";
  effect.physics = "the sensing axes turn in the package as it expands: misalignment that changes with temperature";
  effect.twins = {"fixture_tilt"};
  effect.experiment = "the unit remounted by 90 degrees: misalignment turns with it, a tilt of the fixture does not";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (!in.observations.has_positions()) return "one attitude only";
    if (in.observations.level_count() < 2) return "one temperature only";
    return std::nullopt;
  };
  effect.candidates = [](const RegressorInputs& in) {
    const Eigen::VectorXd z = reduced_temperature(in.observations);
    Candidate candidate;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Eigen::MatrixXd columns(z.size(), 2);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        const Observation& row = in.observations.rows[static_cast<std::size_t>(i)];
        const double g = in.observations.gravity_mps2;
        columns(i, 0) = z(i) * g * in.observations.force_g(row, (axis + 1) % 3);
        columns(i, 1) = z(i) * g * in.observations.force_g(row, (axis + 2) % 3);
      }
      candidate.columns[axis + 3] = columns;
    }
    return std::vector{std::move(candidate)};
  };
  effect.magnitude = [](const RegressorInputs& in, const Candidate&, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() / half_range_c(in.observations), "rad/K"};
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate&, Sensor sensor) {
    const double per_c = 1.0 / half_range_c(in.observations);
    return Meaning{{{axis_name(axis_of(sensor) + 1), "rad/K", per_c}, {axis_name(axis_of(sensor) + 2), "rad/K", per_c}},
                   {{"reference_c", middle_c(in.observations), "degC"}}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
