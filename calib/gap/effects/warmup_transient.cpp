// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr std::array kTaus_s = {100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0};

std::vector<Candidate> of_tau(const Circumstances& c, double tau_s) {
  const Eigen::ArrayXd since = as_vector(c.courses.since_power_s()).array();
  Candidate candidate{.shape = fmt::format("tau {:.3g} s", tau_s), .shape_values = {tau_s}};
  set_all(candidate, (-since / tau_s).exp().matrix());
  return {std::move(candidate)};
}

}  // namespace

Effect warmup_transient() {
  Effect effect;
  effect.name = "warmup_transient";
  effect.physics = "self-heating and settling of references after power-on, whatever the chamber does";
  effect.twins = {"thermal_hysteresis", "temperature_rate"};
  effect.experiment = "a power cycle in the middle of a run";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    if (c.courses.since_power_s().empty()) return "the time since power-on is not known";
    return c.courses.coarse();
  };
  effect.of_course = true;
  effect.candidates = [](const Circumstances& c) { return over_grid(c, kTaus_s, of_tau); };
  effect.of_shape = of_tau;
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "");
  };
  effect.meaning = [](const Circumstances&, const Candidate& candidate, Sensor sensor) {
    return Meaning{{{"amplitude", si_unit(sensor)}}, {{"tau_s", candidate.shape_values.front(), "s"}}};
  };
  return effect;
}

}  // namespace soak::calib::gap
