// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr double kLeastSpread_v = 1e-3;

}  // namespace

Effect supply_sensitivity() {
  Effect effect;
  effect.name = "supply_sensitivity";
  effect.physics = "bias follows the supply voltage";
  effect.twins = {"aging_drift"};
  effect.experiment = "a step of the supply at one temperature";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    const auto& volts = c.courses.supply_v();
    if (volts.empty()) return "the supply voltage was not logged";
    const Eigen::VectorXd v = as_vector(volts);
    if (v.maxCoeff() - v.minCoeff() < kLeastSpread_v) return "the supply voltage never changed";
    return std::nullopt;
  };
  effect.candidates = [](const Circumstances& c) {
    Eigen::VectorXd volts = as_vector(c.courses.supply_v());
    volts.array() -= volts.mean();
    Candidate candidate;
    set_all(candidate, volts);
    return std::vector<Candidate>{candidate};
  };
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, "/V");
  };
  effect.meaning = [](const Circumstances& c, const Candidate&, Sensor sensor) {
    return Meaning{{{"per_v", si_unit(sensor) + "/V"}}, {{"reference_v", as_vector(c.courses.supply_v()).mean(), "V"}}};
  };
  return effect;
}

}  // namespace soak::calib::gap
