// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

Effect scale_nonlinearity() {
  Effect effect;
  effect.name = "scale_nonlinearity";
  effect.physics =
      "an accelerometer's output is not linear: both ends of its range deviate in the same direction. Odd orders look "
      "like scale in six positions";
  effect.twins = {"fixture_tilt"};
  effect.experiment = "positions at 45 degrees";
  effect.missing = one_attitude_only;
  effect.candidates = [](const RegressorInputs& in) {
    Candidate candidate;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd column(static_cast<Eigen::Index>(in.observations.rows.size()));
      for (Eigen::Index i = 0; i < column.size(); ++i) {
        const double f = in.observations.force_g(in.observations.rows[static_cast<std::size_t>(i)], axis);
        column(i) = f * f;
      }
      candidate.columns[axis + 3] = column;
    }
    return std::vector{std::move(candidate)};
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "/g2");
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate&, Sensor) {
    const double g = in.observations.gravity_mps2;
    return Meaning{{{"even_order", "1/(m/s2)", 1.0 / (g * g)}}, {{"gravity", g, "m/s2"}}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
