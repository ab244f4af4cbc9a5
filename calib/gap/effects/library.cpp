// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "calib/gap/effects/effect.h"

namespace soak::calib::gap {

// One maker per file of this folder.
Effect thermal_hysteresis();
Effect temperature_rate();
Effect sensor_lag();
Effect warmup_transient();
Effect g_sensitivity();
Effect earth_rate();
Effect cross_axis();
Effect fixture_tilt();
Effect scale_nonlinearity();
Effect vibration_rectification();
Effect supply_sensitivity();
Effect temperature_gradient();
Effect position_memory();
Effect moisture();

const std::vector<Effect>& library() {
  static const std::vector<Effect> effects = {thermal_hysteresis(), temperature_rate(),
                                              sensor_lag(),         warmup_transient(),
                                              g_sensitivity(),      earth_rate(),
                                              cross_axis(),         fixture_tilt(),
                                              scale_nonlinearity(), vibration_rectification(),
                                              supply_sensitivity(), temperature_gradient(),
                                              position_memory(),    moisture()};
  return effects;
}

bool are_twins(const Effect& a, const Effect& b) {
  const auto lists = [](const Effect& effect, std::string_view name) {
    return std::find(effect.twins.begin(), effect.twins.end(), name) != effect.twins.end();
  };
  return lists(a, b.name) || lists(b, a.name);
}

}  // namespace soak::calib::gap
