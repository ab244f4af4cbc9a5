// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/sim/electronics/unit_electronics.h"

namespace soak::hal::sim {

/// A Crossbow AHRS400 of 100 °/s and 2 g: commands of one byte; in scaled mode packets of 24 bytes, asked for one by
/// one (G) or sent without being asked (C) every sixth or seventh internal sample. Wakes up idle and forgets what it
/// was told. The modes "voltage" and "angle" are known by name only: nothing is measured in them.
class Ahrs400Device final : public UnitElectronics {
 public:
  using UnitElectronics::UnitElectronics;

  void switch_power(bool on, Tick now) override;
  void receive(std::span<const std::uint8_t> bytes, Tick now) override;
  void advance_to(Tick now, const Attitude& fixture) override;
  [[nodiscard]] bool streams() const override { return state_ == State::streaming; }

 private:
  enum class State : std::uint8_t { off, booting, idle, streaming };

  void obey(char command, Tick now);
  void tell_serial_number();
  /// Ticks from packet number `sent_` to the next.
  [[nodiscard]] Tick step() const;
  void send_packet(Tick now, const Attitude& fixture);

  State state_ = State::off;
  bool scaled_ = false;
  std::uint64_t sent_ = 0;
};

}  // namespace soak::hal::sim
