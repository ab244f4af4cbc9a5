// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr std::array kTaus_s = {100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0};

std::vector<Candidate> candidates(const Circumstances& c) {
  const Eigen::ArrayXd since = as_vector(c.courses.since_power_s()).array();
  std::vector<Candidate> list;
  for (const double tau_s : kTaus_s) {
    Candidate candidate{.shape = fmt::format("tau {:g} s", tau_s), .shape_values = {tau_s}};
    set_all(candidate, (-since / tau_s).exp().matrix());
    list.push_back(std::move(candidate));
  }
  return list;
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
    return std::nullopt;
  };
  effect.candidates = candidates;
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "");
  };
  effect.meaning = [](const Circumstances&, const Candidate& candidate, Sensor sensor) {
    return Meaning{{{"amplitude", si_unit(sensor)}}, {{"tau_s", candidate.shape_values.front(), "s"}}};
  };
  return effect;
}

}  // namespace soak::calib::gap
