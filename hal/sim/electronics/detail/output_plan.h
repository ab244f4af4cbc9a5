// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "hal/sim/lab/device_time.h"

namespace soak::hal::sim {

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

}  // namespace soak::hal::sim
