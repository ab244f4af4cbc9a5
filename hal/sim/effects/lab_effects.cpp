// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/lab_effects.h"

#include "hal/sim/campaign/run_plan.h"

namespace soak::hal::sim {

std::vector<LabEffect> lab_effects(const CampaignConfig& config, int number) {
  const double accel_weight = mps2_per_dps(config.design.value_or(default_design(DesignKind::identical)));
  std::vector<LabEffect> effects;
  for (const HiddenSpec& spec : config.hidden) {
    effects.push_back({draw_effect(spec, number, accel_weight), spec.amplitude.value_or(0.0)});
  }
  return effects;
}

EffectSurroundings lab_surroundings(const CampaignConfig& config) {
  EffectSurroundings surroundings{config.earth, {}};
  for (const SetPoint& point : campaign_set_points(config)) {
    if (point.sweep == calib::Sweep::up) surroundings.set_points_c.push_back(point.temp_c);
  }
  return surroundings;
}

}  // namespace soak::hal::sim
