// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "calib/gap/effects/detail/list.h"

namespace soak::calib::gap {

const std::vector<Effect>& library() {
  static const std::vector<Effect> effects = {
      thermal_hysteresis(), temperature_rate(), sensor_lag(),   warmup_transient(),   g_sensitivity(),
      earth_rate(),         cross_axis(),       fixture_tilt(), scale_nonlinearity(), vibration_rectification(),
      supply_sensitivity()};
  return effects;
}

bool are_twins(const Effect& a, const Effect& b) {
  const auto lists = [](const Effect& effect, std::string_view name) {
    return std::find(effect.twins.begin(), effect.twins.end(), name) != effect.twins.end();
  };
  return lists(a, b.name) || lists(b, a.name);
}

}  // namespace soak::calib::gap
