// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/list.h"

namespace soak::calib::gap {

const std::vector<Effect>& library() {
  static const std::vector<Effect> effects = {
      thermal_hysteresis(), temperature_rate(), sensor_lag(),   warmup_transient(),   g_sensitivity(),
      earth_rate(),         cross_axis(),       fixture_tilt(), scale_nonlinearity(), vibration_rectification(),
      supply_sensitivity()};
  return effects;
}

}  // namespace soak::calib::gap
