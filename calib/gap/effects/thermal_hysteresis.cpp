// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"
#include "calib/gap/effects/meaning.h"

namespace soak::calib::gap {
namespace {

constexpr std::array kWidths_c = {2.0, 6.0, 15.0, 35.0};

std::vector<Candidate> of_width(const Circumstances& c, double width_c) {
  const Eigen::VectorXd memory = as_vector(c.courses.branch_memory(width_c));
  Candidate constant{.shape = fmt::format("width {:.3g} K", width_c), .shape_values = {width_c}};
  set_all(constant, memory);
  Candidate shaped{.shape = fmt::format("width {:.3g} K, linear in temperature", width_c), .shape_values = {width_c}};
  set_all(shaped, with_temperature_shape(c.observations, memory));
  return {std::move(constant), std::move(shaped)};
}

/// Largest half gap: over the levels, half the difference between the branches.
Magnitude magnitude(const Circumstances& c, const Candidate& candidate, Sensor sensor, const Eigen::VectorXd& theta) {
  const Eigen::VectorXd term = candidate.columns[index_of(sensor)] * theta;
  const auto levels = static_cast<std::size_t>(c.observations.level_count());
  std::vector<double> low(levels, std::numeric_limits<double>::infinity());
  std::vector<double> high(levels, -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < c.observations.rows.size(); ++i) {
    const auto k = static_cast<std::size_t>(c.observations.rows[i].level);
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
      "stress in package and solder depends on the way to a temperature, not on its speed; it stays after "
      "the soak";
  effect.twins = {"temperature_rate", "sensor_lag", "warmup_transient"};
  effect.experiment = "a longer soak (memory stays, what follows the rate dies) and a minor loop that turns halfway";
  effect.missing = [](const Circumstances& c) { return c.courses.blurred(); };
  effect.of_course = true;
  effect.candidates = [](const Circumstances& c) { return over_grid(c, kWidths_c, of_width); };
  effect.of_shape = of_width;
  effect.magnitude = magnitude;
  effect.meaning = [](const Circumstances& c, const Candidate& candidate, Sensor sensor) {
    Meaning meaning = temperature_shaped(c, candidate, sensor, "amplitude", "");
    meaning.given.push_back({"width_c", candidate.shape_values.front(), "K"});
    return meaning;
  };
  return effect;
}

}  // namespace soak::calib::gap
