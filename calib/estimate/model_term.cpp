// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/model_term.h"

#include <algorithm>

namespace soak::calib {

bool TermPart::acts_on(Sensor sensor) const {
  return std::find(sensors.begin(), sensors.end(), sensor) != sensors.end();
}

std::optional<double> TermPart::value(std::string_view name) const {
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const TermParameter& parameter) { return parameter.name == name; });
  if (found == parameters.end()) return std::nullopt;
  return found->value;
}

const TermPart* ModelTerm::part_of(Sensor sensor) const {
  const auto found =
      std::find_if(parts.begin(), parts.end(), [&](const TermPart& part) { return part.acts_on(sensor); });
  return found == parts.end() ? nullptr : &*found;
}

}  // namespace soak::calib
