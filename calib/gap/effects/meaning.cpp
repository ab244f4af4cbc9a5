// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/meaning.h"

#include <array>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {

std::string si_unit(Sensor sensor) { return is_gyro(sensor) ? "rad/s" : "m/s2"; }

std::string axis_name(std::size_t axis) {
  constexpr std::array<std::string_view, 3> kNames = {"x", "y", "z"};
  return std::string(kNames.at(axis % kNames.size()));
}

double middle_c(const Observations& observations) {
  return 0.5 * (observations.level_c.back() + observations.level_c.front());
}

Meaning temperature_shaped(const Circumstances& c, const Candidate& candidate, Sensor sensor, std::string_view name,
                           std::string_view per) {
  const std::string unit = si_unit(sensor) + std::string(per);
  Meaning meaning{{{std::string(name), unit}}, {}};
  if (candidate.columns[index_of(sensor)].cols() < 2) return meaning;
  meaning.estimated.push_back({std::string(name) + "_per_c", unit + "/K", 1.0 / half_range_c(c.observations)});
  meaning.given.push_back({"reference_c", middle_c(c.observations), "degC"});
  return meaning;
}

}  // namespace soak::calib::gap
