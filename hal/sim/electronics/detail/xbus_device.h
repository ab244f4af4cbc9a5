// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "hal/sim/electronics/unit_electronics.h"
#include "hal/sim/lab/device_time.h"

namespace soak::hal::sim {

/// A message of the Xbus protocol.
struct XbusMessage {
  std::uint8_t id = 0;
  base::Bytes data;
};

/// FA FF id length data checksum: all bytes after FA add up to 0 modulo 256. Data longer than 254 bytes take the
/// extended length FF + 16 bits.
[[nodiscard]] base::Bytes xbus_frame(std::uint8_t id, std::span<const std::uint8_t> data);

/// Finds messages in the bytes that a host sends. After a wrong checksum it looks for the next FA within the frame.
class XbusParser {
 public:
  void feed(std::span<const std::uint8_t> bytes) { pending_.insert(pending_.end(), bytes.begin(), bytes.end()); }
  /// The next message; nothing while none is complete.
  [[nodiscard]] std::optional<XbusMessage> next();
  void clear() { pending_.clear(); }

 private:
  base::Bytes pending_;
};

/// Data identifiers that the units can put out.
inline constexpr std::uint16_t kTemperature = 0x0810;
inline constexpr std::uint16_t kPacketCounter = 0x1020;
inline constexpr std::uint16_t kSampleTimeFine = 0x1060;
inline constexpr std::uint16_t kAcceleration = 0x4020;
inline constexpr std::uint16_t kRateOfTurn = 0x8020;
inline constexpr std::uint16_t kStatusWord = 0xE020;

/// One line of an output configuration.
struct OutputItem {
  std::uint16_t id = 0;
  Tick divider = 0;  ///< due each so many ticks; 0 = with every packet

  /// 0 where the item comes with every packet.
  [[nodiscard]] double rate_hz() const {
    return divider > 0 ? static_cast<double>(kTicksPerSecond) / static_cast<double>(divider) : 0.0;
  }
};

/// What a unit puts in its packets, and when.
class OutputPlan {
 public:
  /// As units leave the factory: 100 Hz, temperature at 10 Hz.
  [[nodiscard]] static OutputPlan factory();

  /// The plan that the data of message C0 ask for: identifier and rate of each item. Rates become the nearest 400/n Hz;
  /// counter, time and status come with every packet. Nothing where an item is unknown or a rate is 0.
  [[nodiscard]] static std::optional<OutputPlan> parse(std::span<const std::uint8_t> data);

  /// Data of message C1: the plan with the rates that it really has.
  [[nodiscard]] base::Bytes data() const;

  [[nodiscard]] const std::vector<OutputItem>& items() const { return items_; }
  [[nodiscard]] static bool due(const OutputItem& item, Tick tick) {
    return item.divider == 0 || tick % item.divider == 0;
  }
  /// First tick after `tick` with a packet; nothing where no item has a rate.
  [[nodiscard]] std::optional<Tick> next_packet(Tick tick) const;

 private:
  std::vector<OutputItem> items_;
};

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
