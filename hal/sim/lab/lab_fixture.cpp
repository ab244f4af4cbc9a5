// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/lab_fixture.h"

#include "hal/sim/lab/detail/simulated_fixture.h"
#include "hal/sim/lab/detail/two_axis_fixture.h"

namespace soak::hal::sim {

std::unique_ptr<LabFixture> make_fixture(FixtureKind kind, const CampaignConfig& config) {
  if (kind == FixtureKind::two_axis) return std::make_unique<TwoAxisFixture>(config.lab.turn_s_per_rad, config.earth);
  return std::make_unique<SimulatedFixture>(config.lab.turn_s_per_rad, config.earth);
}

}  // namespace soak::hal::sim
