// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

Effect g_sensitivity() {
  Effect effect;
  effect.name = "g_sensitivity";
  effect.physics = "specific force unbalances a gyro's vibrating masses: its bias follows the attitude";
  effect.twins = {"earth_rate", "position_memory"};
  effect.experiment =
      "the same positions with the fixture turned in azimuth: g-sensitivity stays, the horizontal part of the Earth's "
      "rotation turns";
  effect.missing = one_attitude_only;
  // All axes; and each gyro by the force along its own, as three parameters more must be paid for.
  effect.candidates = [](const RegressorInputs& in) {
    Eigen::MatrixXd force(static_cast<Eigen::Index>(in.observations.rows.size()), 3);
    for (Eigen::Index i = 0; i < force.rows(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        force(i, static_cast<Eigen::Index>(axis)) =
            in.observations.force_g(in.observations.rows[static_cast<std::size_t>(i)], axis);
      }
    }
    std::vector<Candidate> all_and_own = {{}, {.shape = "own axis"}};
    for (std::size_t gyro = 0; gyro < 3; ++gyro) {
      all_and_own[0].columns[gyro] = force;
      all_and_own[1].columns[gyro] = force.col(static_cast<Eigen::Index>(gyro));
    }
    return all_and_own;
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() * printed_per_si(sensor), std::string(printed_unit(sensor)) + "/g"};
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate& candidate, Sensor sensor) {
    const std::string unit = "(rad/s)/(m/s2)";
    const bool all = candidate.columns[index_of(sensor)].cols() == 3;
    Meaning result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (all || axis == axis_of(sensor)) {
        result.estimated.push_back({axis_name(axis), unit, 1.0 / in.observations.gravity_mps2});
      } else {
        result.given.push_back({axis_name(axis), 0.0, unit});
      }
    }
    return result;
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
