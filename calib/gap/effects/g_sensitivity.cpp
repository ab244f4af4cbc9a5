// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/list.h"

namespace soak::calib::gap {
namespace {

std::vector<Candidate> candidates(const Circumstances& c) {
  Eigen::MatrixXd force(static_cast<Eigen::Index>(c.observations.rows.size()), 3);
  for (Eigen::Index i = 0; i < force.rows(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      force(i, static_cast<Eigen::Index>(axis)) =
          c.observations.force_g(c.observations.rows[static_cast<std::size_t>(i)], axis);
    }
  }
  Candidate candidate;
  set_gyros(candidate, force);
  return {candidate};
}

}  // namespace

Effect g_sensitivity() {
  Effect effect;
  effect.name = "g_sensitivity";
  effect.physics = "specific force unbalances a gyro's vibrating masses: its bias follows the attitude";
  effect.twins = {"earth_rate"};
  effect.experiment =
      "the same positions with the fixture turned in azimuth: g-sensitivity stays, the horizontal part "
      "of the Earth's rotation turns";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    if (!c.observations.has_positions()) return "one attitude only";
    return std::nullopt;
  };
  effect.candidates = candidates;
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() * printed_per_si(sensor), std::string(printed_unit(sensor)) + "/g"};
  };
  effect.meaning = [](const Circumstances& c, const Candidate&, Sensor) {
    const double per_force = 1.0 / c.observations.gravity_mps2;
    return Meaning{
        {{"x", "(rad/s)/(m/s2)", per_force}, {"y", "(rad/s)/(m/s2)", per_force}, {"z", "(rad/s)/(m/s2)", per_force}},
        {}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
