// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

namespace {

Meaning meaning_about(double mean_v, Sensor sensor) {
  return {{{"per_v", si_unit(sensor) + "/V"}}, {{"reference_v", mean_v, "V"}}};
}

}  // namespace

Effect supply_sensitivity() {
  Effect effect;
  effect.name = "supply_sensitivity";
  effect.physics = "bias follows the supply voltage";
  effect.twins = {"aging_drift"};
  effect.experiment = "a step of the supply at one temperature";
  effect.missing = [](const RegressorInputs& in) {
    constexpr double kLeastSpread_v = 1e-3;
    return unmoved_channel(in.history.supply_v(), kLeastSpread_v, "supply voltage");
  };
  effect.candidates = [](const RegressorInputs& in) {
    Eigen::VectorXd volts = as_vector(in.history.supply_v());
    volts.array() -= volts.mean();
    return std::vector{for_all("", {}, volts)};
  };
  effect.on_ramps = [](const Observations&, const TemperatureHistory& history) {
    OnRamps made = channel_on_ramps(history.supply_v(), "/V");
    made.meaning = [mean_v = mean_of(history.supply_v())](const Candidate&, Sensor sensor) {
      return meaning_about(mean_v, sensor);
    };
    return made;
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "/V");
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate&, Sensor sensor) {
    return meaning_about(mean_of(in.history.supply_v()), sensor);
  };
  return effect;
}

}  // namespace soak::calib::gap
