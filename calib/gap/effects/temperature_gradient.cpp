// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// What means of two thermometers over a block tell apart. More is not asked: air that is always settled when the unit
/// is read shows a strong gradient, which would else be taken for its twin.
constexpr double kLeastMove_c = 0.1;

/// The chamber's air less the unit's thermometer, kelvin.
Eigen::VectorXd air_less_unit(const RegressorInputs& in) {
  return as_vector(in.history.chamber_c()) - as_vector(in.history.unit_c());
}

}  // namespace

Effect temperature_gradient() {
  Effect effect;
  effect.name = "temperature_gradient";
  effect.physics = "a gradient across the package, from the air outside to the thermometer inside, bends it";
  effect.twins = {"temperature_rate", "sensor_lag"};
  effect.experiment =
      "a step of the air while the unit is at rest at a plateau: the gradient is there before the unit has warmed";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (in.history.unit_c().empty()) return "the unit's temperature was not logged at every block";
    if (in.history.chamber_c().empty()) return "the chamber's air was not logged in every run (chamber_c)";
    const Eigen::VectorXd across = air_less_unit(in);
    if (across.maxCoeff() - across.minCoeff() < kLeastMove_c) return "the air less the unit was the same all the time";
    return in.history.blurred();
  };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return constant_and_linear(in.observations, "", {}, air_less_unit(in));
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "/K");
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate& candidate, Sensor sensor) {
    return temperature_shaped(in.observations, candidate, sensor, "per_k", "/K");
  };
  return effect;
}

}  // namespace soak::calib::gap
