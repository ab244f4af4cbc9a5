// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// The thermometer's slope, or the difference to a second thermal node that follows it.
OnRamps rate_on_ramps(const Observations& observations, const TemperatureHistory& history) {
  OnRamps made{.candidates = constant_and_linear(observations, "", {}, rate_kpmin(history)), .per = "/(K/min)"};
  made.meaning = [&observations](const Candidate& candidate, Sensor sensor) {
    Meaning meaning = temperature_shaped(observations, candidate, sensor, "per_kps", "/(K/s)");
    // The columns are in K/min.
    for (Meaning::Estimated& estimated : meaning.estimated) estimated.per_parameter *= kMinute_s;
    if (candidate.shape_values.empty()) return meaning;
    for (TermParameter& given : node_shape(candidate.shape_values[0], candidate.shape_values[1] > 0.0)) {
      meaning.given.push_back(std::move(given));
    }
    return meaning;
  };
  for (const double tau_s : kRampTaus_s) {
    for (const bool under_way : {false, true}) {
      // −(T_τ − T)/τ tends to dT/dt on a long ramp.
      const Eigen::VectorXd column = -kMinute_s / tau_s * as_vector(history.lag(tau_s, under_way));
      const auto text = fmt::format("tau {:g} s{}", tau_s, start_text(under_way));
      for (Candidate& candidate : constant_and_linear(observations, text, {tau_s, under_way ? 1.0 : 0.0}, column)) {
        made.candidates.push_back(std::move(candidate));
      }
    }
  }
  return made;
}

}  // namespace

Effect temperature_rate() {
  Effect effect;
  effect.name = "temperature_rate";
  effect.physics =
      "gradients across the unit while it warms or cools: in proportion to dT/dt of its thermometer, gone once the "
      "plateau is settled";
  effect.twins = {"sensor_lag", "warmup_transient"};
  effect.experiment = "two ramp rates, watched during the ramp and at the start of the soak";
  effect.missing = [](const RegressorInputs& in) { return in.history.blurred(); };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return constant_and_linear(in.observations, "", {}, as_vector(in.history.rate()));
  };
  effect.on_ramps = rate_on_ramps;
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0 / kMinute_s, "/(K/min)");
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate& candidate, Sensor sensor) {
    return temperature_shaped(in.observations, candidate, sensor, "per_kps", "/(K/s)");
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
