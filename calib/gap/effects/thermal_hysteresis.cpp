// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

std::vector<Candidate> hysteresis_of_width(const RegressorInputs& in, double width_c) {
  return constant_and_linear(in.observations, fmt::format("width {:.3g} K", width_c), {width_c},
                             as_vector(in.history.branch_memory(width_c)));
}

/// Widths of 2 to 70 K, each run on either branch before its start or between them.
OnRamps hysteresis_on_ramps(const Observations& observations, const TemperatureHistory& history) {
  OnRamps made{.size = OnRamps::Size::largest};
  made.meaning = [&observations](const Candidate& candidate, Sensor sensor) {
    Meaning meaning = temperature_shaped(observations, candidate, sensor, "amplitude", "");
    meaning.given.push_back({"width_c", candidate.shape_values.at(0), "K"});
    meaning.given.push_back({"starts_along", candidate.shape_values.at(1), "1"});
    return meaning;
  };
  for (const double width_c : {2.0, 6.0, 15.0, 35.0, 70.0}) {
    for (const double along : {1.0, 0.0, -1.0}) {
      const auto text = fmt::format("width {:g} K, before the start {}", width_c,
                                    along > 0.0   ? "as the first branch"
                                    : along < 0.0 ? "against the first branch"
                                                  : "neither way");
      const Eigen::VectorXd memory = as_vector(history.branch_memory(width_c, along));
      for (Candidate& candidate : constant_and_linear(observations, text, {width_c, along}, memory)) {
        made.candidates.push_back(std::move(candidate));
      }
    }
  }
  return made;
}

/// Largest half gap: over the levels, half the difference between the branches.
Magnitude largest_half_gap(const RegressorInputs& in, const Candidate& candidate, Sensor sensor,
                           const Eigen::VectorXd& theta) {
  const Eigen::VectorXd term = candidate.columns[index_of(sensor)] * theta;
  const auto levels = static_cast<std::size_t>(in.observations.level_count());
  std::vector<double> low(levels, std::numeric_limits<double>::infinity());
  std::vector<double> high(levels, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < in.observations.rows.size(); ++i) {
    const auto k = static_cast<std::size_t>(in.observations.rows[i].level);
    low[k] = std::min(low[k], term(static_cast<Eigen::Index>(i)));
    high[k] = std::max(high[k], term(static_cast<Eigen::Index>(i)));
  }
  double largest = 0.0;
  for (std::size_t k = 0; k < levels; ++k) largest = std::max(largest, 0.5 * (high[k] - low[k]));
  return {largest * printed_per_si(sensor), std::string(printed_unit(sensor))};
}

}  // namespace

Effect thermal_hysteresis() {
  Effect effect;
  effect.name = "thermal_hysteresis";
  effect.physics =
      "stress in package and solder depends on the way to a temperature, not on the speed; it stays after the soak";
  effect.twins = {"temperature_rate", "sensor_lag", "warmup_transient", "moisture"};
  effect.experiment = "a longer soak (memory stays, rate effects die out) and a minor loop that turns halfway";
  effect.missing = [](const RegressorInputs& in) { return in.history.blurred(); };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return over_grid(in, std::array{2.0, 6.0, 15.0, 35.0}, hysteresis_of_width);
  };
  effect.of_shape = hysteresis_of_width;
  effect.on_ramps = hysteresis_on_ramps;
  effect.magnitude = largest_half_gap;
  effect.meaning = [](const RegressorInputs& in, const Candidate& candidate, Sensor sensor) {
    Meaning meaning = temperature_shaped(in.observations, candidate, sensor, "amplitude", "");
    meaning.given.push_back({"width_c", candidate.shape_values.front(), "K"});
    return meaning;
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
