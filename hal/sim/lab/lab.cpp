// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/lab.h"

#include <algorithm>

namespace soak::hal::sim {

Lab::Lab(const CampaignConfig& config, const LabKinds& kinds)
    : chamber_(config.lab, config.seed),
      fixture_(make_fixture(kinds.fixture, config)),
      relay_([this](int output, bool on) {
        const auto index = static_cast<std::size_t>(output - 1);
        if (index < devices_.size()) devices_[index]->switch_power(on, now_);
      }) {
  for (int number = 1; number <= config.units; ++number) {
    devices_.push_back(make_unit(kinds.unit(number), config, number));
  }
}

UnitKind LabKinds::unit(int number) const {
  return units[std::min(static_cast<std::size_t>(number), units.size()) - 1];
}

Tick Lab::next_due() const {
  Tick next = (now_ / kTicksPerStep + 1) * kTicksPerStep;
  for (const auto& device : devices_) next = std::min(next, device->next_due());
  return next;
}

void Lab::advance_to(Tick next) {
  now_ = next;
  fixture_->advance_to(now_);
  const Attitude attitude = fixture_->attitude();
  if (now_ % kTicksPerStep == 0) {
    chamber_.step(kStep_s);
    for (const auto& device : devices_) device->unit().step(chamber_.plant(), attitude);
  }
  for (const auto& device : devices_) device->advance_to(now_, attitude);
}

}  // namespace soak::hal::sim
