// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr double kLeastSpread = 0.02;  ///< of the duty within the campaign

}  // namespace

Effect vibration_rectification() {
  Effect effect;
  effect.name = "vibration_rectification";
  effect.physics = "the compressor shakes the fixture, and an uneven response to vibration makes a shift of the mean";
  effect.twins = {"temperature_rate"};
  effect.experiment = "a hold at one temperature with the compressor forced on, then off";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    const auto& duty = c.courses.compressor();
    if (duty.empty()) return "the compressor's duty was not logged";
    const Eigen::VectorXd v = as_vector(duty);
    if (v.maxCoeff() - v.minCoeff() < kLeastSpread) return "the compressor's duty never changed";
    return std::nullopt;
  };
  effect.candidates = [](const Circumstances& c) {
    Candidate candidate;
    set_all(candidate, as_vector(c.courses.compressor()));
    return std::vector<Candidate>{candidate};
  };
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return linear_magnitude(sensor, theta, 1.0, " per unit duty");
  };
  effect.meaning = [](const Circumstances&, const Candidate&, Sensor sensor) {
    return Meaning{{{"per_duty", si_unit(sensor)}}, {}};
  };
  return effect;
}

}  // namespace soak::calib::gap
