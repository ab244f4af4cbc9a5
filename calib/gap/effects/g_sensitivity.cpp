// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr std::string_view kUnit = "(rad/s)/(m/s2)";

/// All axes; and each gyro by the force along its own, as three parameters more must be paid for.
std::vector<Candidate> candidates(const Circumstances& c) {
  Eigen::MatrixXd force(static_cast<Eigen::Index>(c.observations.rows.size()), 3);
  for (Eigen::Index i = 0; i < force.rows(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      force(i, static_cast<Eigen::Index>(axis)) =
          c.observations.force_g(c.observations.rows[static_cast<std::size_t>(i)], axis);
    }
  }
  Candidate all;
  set_gyros(all, force);
  Candidate own{.shape = "own axis"};
  for (std::size_t gyro = 0; gyro < 3; ++gyro) own.columns[gyro] = force.col(static_cast<Eigen::Index>(gyro));
  return {std::move(all), std::move(own)};
}

Meaning meaning(const Circumstances& c, const Candidate& candidate, Sensor sensor) {
  const bool all = candidate.columns[index_of(sensor)].cols() == 3;
  Meaning result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (all || axis == axis_of(sensor)) {
      result.estimated.push_back({axis_name(axis), std::string(kUnit), 1.0 / c.observations.gravity_mps2});
    } else {
      result.given.push_back({axis_name(axis), 0.0, std::string(kUnit)});
    }
  }
  return result;
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
  effect.meaning = meaning;
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
