// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

Candidate decay_of_tau(const std::vector<double>& since_power_s, double tau_s, std::string shape) {
  return for_all(std::move(shape), {tau_s}, (-as_vector(since_power_s).array() / tau_s).exp().matrix());
}

std::vector<Candidate> warmup_of_tau(const RegressorInputs& in, double tau_s) {
  return {decay_of_tau(in.history.since_power_s(), tau_s, fmt::format("tau {:.3g} s", tau_s))};
}

Meaning meaning_of_decay(const Candidate& candidate, Sensor sensor) {
  return {{{"amplitude", si_unit(sensor)}}, {{"tau_s", candidate.shape_values.front(), "s"}}};
}

}  // namespace

Effect warmup_transient() {
  Effect effect;
  effect.name = "warmup_transient";
  effect.physics = "self-heating and settling of voltage references after power-on, whatever the chamber does";
  effect.twins = {"thermal_hysteresis", "temperature_rate"};
  effect.experiment = "a power cycle in the middle of a run";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (in.history.since_power_s().empty()) return "the time since power-on is not known";
    return in.history.coarse();
  };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return over_grid(in, std::array{100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0}, warmup_of_tau);
  };
  effect.of_shape = warmup_of_tau;
  effect.on_ramps = [](const Observations&, const TemperatureHistory& history) {
    OnRamps made;
    made.meaning = meaning_of_decay;
    if (history.since_power_s().empty()) return made;
    for (const double tau_s : {200.0, 400.0, 800.0, 1600.0, 3200.0}) {
      made.candidates.push_back(decay_of_tau(history.since_power_s(), tau_s, fmt::format("tau {:g} s", tau_s)));
    }
    return made;
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "");
  };
  effect.meaning = [](const RegressorInputs&, const Candidate& candidate, Sensor sensor) {
    return meaning_of_decay(candidate, sensor);
  };
  return effect;
}

}  // namespace soak::calib::gap
