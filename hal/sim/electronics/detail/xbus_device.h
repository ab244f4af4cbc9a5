// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "hal/sim/electronics/detail/output_plan.h"
#include "hal/sim/electronics/detail/xbus_frame.h"
#include "hal/sim/electronics/unit_electronics.h"

namespace soak::hal::sim {

/// States and messages of an Xsens MTi. The output configuration is kept without power.
class XbusDevice final : public UnitElectronics {
 public:
  using UnitElectronics::UnitElectronics;

  void switch_power(bool on, Tick now) override;
  void receive(std::span<const std::uint8_t> bytes, Tick now) override;
  void advance_to(Tick now, const Attitude& fixture) override;
  [[nodiscard]] bool streams() const override { return state_ == State::measuring; }

 private:
  enum class State : std::uint8_t { off, booting, waking, configuring, measuring };

  void boot(Tick now);
  void enter(State state, Tick now);
  void send(std::uint8_t id, std::span<const std::uint8_t> data = {});
  void answer(const XbusMessage& message, Tick now);
  void answer_configuring(const XbusMessage& message);
  void configure_output(const XbusMessage& message);
  /// Data of the measurement message that is due.
  [[nodiscard]] base::Bytes packet(Tick since_start, const Attitude& fixture) const;

  OutputPlan plan_ = OutputPlan::factory();
  State state_ = State::off;
  std::uint16_t packet_counter_ = 0;
  XbusParser parser_;
};

}  // namespace soak::hal::sim
