// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "base/bytes.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/inertial_unit.h"
#include "hal/sim/lab/output_plan.h"
#include "hal/sim/lab/xbus_frame.h"

namespace soak::hal::sim {

/// The electronics of a unit as its host sees it: power, states and messages of an Xsens MTi. The output configuration
/// is kept without power.
class XbusDevice {
 public:
  static constexpr Tick kNever = std::numeric_limits<Tick>::max();

  XbusDevice(const CampaignConfig& config, int number);

  void switch_power(bool on, Tick now);
  /// Bytes from the host.
  void receive(std::span<const std::uint8_t> bytes, Tick now);
  /// Does what is due at `now`.
  void advance_to(Tick now, const Attitude& fixture);
  /// Next tick at which something is due.
  [[nodiscard]] Tick next_due() const { return next_due_; }

  /// Measures and sends packets.
  [[nodiscard]] bool streams() const { return state_ == State::measuring; }
  [[nodiscard]] InertialUnit& unit() { return unit_; }
  /// Bytes for the host since the last call.
  [[nodiscard]] base::Bytes take_output();
  [[nodiscard]] std::size_t output_size() const { return output_.size(); }

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

  ElectronicsMagnitudes magnitudes_;
  InertialUnit unit_;
  OutputPlan plan_ = OutputPlan::factory();
  State state_ = State::off;
  Tick start_ = 0;
  Tick next_due_ = kNever;
  std::uint16_t packet_counter_ = 0;
  XbusParser parser_;
  base::Bytes output_;
};

}  // namespace soak::hal::sim
