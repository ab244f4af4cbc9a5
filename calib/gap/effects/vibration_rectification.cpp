// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

namespace {

Meaning meaning_per_duty(Sensor sensor) { return {{{"per_duty", si_unit(sensor)}}, {}}; }

}  // namespace

Effect vibration_rectification() {
  Effect effect;
  effect.name = "vibration_rectification";
  effect.physics = "the compressor shakes the fixture, and an uneven response to vibration shifts the mean";
  effect.twins = {"temperature_rate"};
  effect.experiment = "a hold at one temperature with the compressor forced on, then off";
  effect.missing = [](const RegressorInputs& in) {
    constexpr double kLeastSpread = 0.02;  // of the duty within the campaign
    return unmoved_channel(in.history.compressor(), kLeastSpread, "compressor's duty");
  };
  effect.candidates = [](const RegressorInputs& in) {
    return std::vector{for_all("", {}, as_vector(in.history.compressor()))};
  };
  effect.on_ramps = [](const Observations&, const TemperatureHistory& history) {
    OnRamps made = channel_on_ramps(history.compressor(), "");
    made.meaning = [](const Candidate&, Sensor sensor) { return meaning_per_duty(sensor); };
    return made;
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, " per unit duty");
  };
  effect.meaning = [](const RegressorInputs&, const Candidate&, Sensor sensor) { return meaning_per_duty(sensor); };
  return effect;
}

}  // namespace soak::calib::gap
