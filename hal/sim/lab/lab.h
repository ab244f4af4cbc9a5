// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "hal/sim/config/campaign_config.h"
#include "hal/sim/electronics/unit_electronics.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/lab_fixture.h"
#include "hal/sim/lab/register_table.h"
#include "hal/sim/lab/simulated_chamber.h"

namespace soak::hal::sim {

inline constexpr int kRelayOutputs = 64;
inline constexpr int kRelayCardOutputs = 16;  ///< of the card itself; the others are those of its extensions

/// The relay card that feeds the units, with extensions of further outputs. All outputs are off at the start; they
/// switch at once.
class SimulatedRelay {
 public:
  /// `switched` is told each output (from 1) that changes.
  explicit SimulatedRelay(std::function<void(int output, bool on)> switched);
  SimulatedRelay(const SimulatedRelay&) = delete;
  SimulatedRelay& operator=(const SimulatedRelay&) = delete;

  [[nodiscard]] RegisterTable& registers() { return registers_; }

 private:
  std::function<void(int, bool)> switched_;
  std::array<bool, kRelayOutputs> on_{};
  RegisterTable registers_;
};

/// What stands in the laboratory.
struct LabKinds {
  FixtureKind fixture = FixtureKind::six_positions;
  std::vector<UnitKind> units{UnitKind::xsens};  ///< of slot 1, 2, ..., the last counting for all that follow

  /// Of slot `number`, from 1.
  [[nodiscard]] UnitKind unit(int number) const;
};

/// The whole laboratory in its own time: a chamber with a fixture in it, units on the fixture, a relay card that feeds
/// them. What happens depends on the configuration and on what is written at which tick, and on nothing else.
class SimulatedLab {
 public:
  /// `config.units` units: relay output n feeds unit n.
  explicit SimulatedLab(const CampaignConfig& config, const LabKinds& kinds = {});

  [[nodiscard]] Tick now() const { return now_; }
  /// Next tick at which anything happens.
  [[nodiscard]] Tick next_due() const;
  /// Advances to `next`, which must not be after next_due().
  void advance_to(Tick next);

  [[nodiscard]] SimulatedChamber& chamber() { return chamber_; }
  [[nodiscard]] LabFixture& fixture() { return *fixture_; }
  [[nodiscard]] SimulatedRelay& relay() { return relay_; }
  [[nodiscard]] std::size_t unit_count() const { return devices_.size(); }
  /// `index` counts from 0.
  [[nodiscard]] UnitElectronics& device(std::size_t index) { return *devices_[index]; }
  [[nodiscard]] const UnitElectronics& device(std::size_t index) const { return *devices_[index]; }

 private:
  Tick now_ = 0;
  SimulatedChamber chamber_;
  std::unique_ptr<LabFixture> fixture_;
  SimulatedRelay relay_;
  std::vector<std::unique_ptr<UnitElectronics>> devices_;
};

}  // namespace soak::hal::sim
