// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr double kPerMinute = 1.0 / 60.0;

std::vector<Candidate> candidates(const Circumstances& c) {
  const Eigen::VectorXd rate = as_vector(c.courses.rate());
  Candidate constant{.shape = ""};
  set_all(constant, rate);
  Candidate shaped{.shape = "linear in temperature"};
  set_all(shaped, with_temperature_shape(c.observations, rate));
  return {constant, shaped};
}

}  // namespace

Effect temperature_rate() {
  Effect effect;
  effect.name = "temperature_rate";
  effect.physics =
      "gradients across the unit while it warms or cools: in proportion to dT/dt of its thermometer, gone "
      "once the plateau is settled";
  effect.twins = {"sensor_lag", "warmup_transient"};
  effect.experiment = "two ramp rates, watched during the ramp and at the start of the soak";
  effect.missing = [](const Circumstances& c) { return c.courses.blurred(); };
  effect.of_course = true;
  effect.candidates = candidates;
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, kPerMinute, "/(K/min)");
  };
  effect.meaning = [](const Circumstances& c, const Candidate& candidate, Sensor sensor) {
    return temperature_shaped(c, candidate, sensor, "per_kps", "/(K/s)");
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
