// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/lab.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace soak::hal::sim {
namespace {

constexpr int kRelayState = 16;
constexpr int kRelayIdentification = 32;
constexpr int kRelayIdentity = 0x5052;
constexpr int kExtension = 64;  ///< of the first output beyond the card's own
constexpr int kExtensionState = 128;

/// Registers of an output (from 0): what is asked for, and its state.
struct OutputRegisters {
  int asked;
  int state;
};

OutputRegisters registers_of(int output) {
  if (output < kRelayCardOutputs) return {output, kRelayState + output};
  return {kExtension + output - kRelayCardOutputs, kExtensionState + output - kRelayCardOutputs};
}

}  // namespace

SimulatedRelay::SimulatedRelay(std::function<void(int, bool)> switched) : switched_(std::move(switched)) {
  for (int output = 0; output < kRelayOutputs; ++output) {
    bool& on = on_[static_cast<std::size_t>(output)];
    const auto read = [&on] { return on ? 1 : 0; };
    const auto store = [this, &on, output](int request) {
      if (on == (request == 1)) return;
      on = request == 1;
      switched_(output + 1, on);
    };
    const auto [asked, state] = registers_of(output);
    registers_.add_number(asked, 1, read, {[](int request) { return request == 0 || request == 1; }, store});
    registers_.add_number(state, 1, read);
  }
  registers_.add_number(kRelayIdentification, 1, [] { return kRelayIdentity; });
}

SimulatedLab::SimulatedLab(const CampaignConfig& config, const LabKinds& kinds)
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

Tick SimulatedLab::next_due() const {
  Tick next = (now_ / kTicksPerStep + 1) * kTicksPerStep;
  for (const auto& device : devices_) next = std::min(next, device->next_due());
  return next;
}

void SimulatedLab::advance_to(Tick next) {
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
