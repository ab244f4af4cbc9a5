// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// Of water that leaves a moulded package: between the 4000 and 7000 K that diffusion in epoxies is known for.
constexpr double kActivation_k = 5500.0;
constexpr double kHour_s = 3600.0;

std::vector<Candidate> dried_in(const RegressorInputs& in, double tau_h) {
  return {for_all(fmt::format("{:.3g} h at 50 °C", tau_h), {tau_h},
                  as_vector(in.history.water_left(tau_h * kHour_s, kActivation_k)))};
}

/// What moves within a run, at most: how much water there was at its start only a run that dries it all would tell.
Magnitude largest_move(const RegressorInputs& in, const Candidate& candidate, Sensor sensor,
                       const Eigen::VectorXd& theta) {
  const Eigen::MatrixXd& water = candidate.columns[index_of(sensor)];
  double largest = 0.0;
  double first = 0.0;
  for (std::size_t i = 0; i < in.observations.rows.size(); ++i) {
    const double here = water(static_cast<Eigen::Index>(i), 0);
    if (i == 0 || in.observations.rows[i].run != in.observations.rows[i - 1].run) first = here;
    largest = std::max(largest, first - here);
  }
  return linear_magnitude(sensor, theta, largest, "");
}

}  // namespace

Effect moisture() {
  Effect effect;
  effect.name = "moisture";
  effect.physics =
      "water that a package took up swells it and dries out, faster the hotter: the bias moves one way within each run "
      "and is back at the start of the next";
  effect.twins = {"thermal_hysteresis", "warmup_transient"};
  effect.experiment = "two runs one after the other without a pause: a unit that was dried does not move again";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (!in.history.continuous()) return "the temperature between the plateaus was not logged";
    return in.history.blurred();
  };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return over_grid(in, std::array{1.0, 2.0, 4.0, 8.0, 16.0}, dried_in);
  };
  effect.of_shape = dried_in;
  effect.magnitude = largest_move;
  effect.meaning = [](const RegressorInputs&, const Candidate& candidate, Sensor sensor) {
    return Meaning{{{"amplitude", si_unit(sensor)}},
                   {{"tau_s", candidate.shape_values.front() * kHour_s, "s"}, {"activation_k", kActivation_k, "K"}}};
  };
  return effect;
}

}  // namespace soak::calib::gap
