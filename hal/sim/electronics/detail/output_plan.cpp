// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/output_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hal/sim/electronics/detail/xbus_frame.h"

namespace soak::hal::sim {
namespace {

constexpr std::uint16_t kEveryPacket = 0xFFFF;
constexpr std::size_t kBytesPerItem = 4;

bool comes_with_every_packet(std::uint16_t id) {
  return id == kPacketCounter || id == kSampleTimeFine || id == kStatusWord;
}

bool has_a_rate(std::uint16_t id) { return id == kTemperature || id == kAcceleration || id == kRateOfTurn; }

Tick divider_of(std::uint16_t rate_hz) {
  const double divider = std::round(static_cast<double>(kTicksPerSecond) / rate_hz);
  return std::max<Tick>(1, static_cast<Tick>(divider));
}

std::uint16_t u16_at(std::span<const std::uint8_t> data, std::size_t at) {
  return static_cast<std::uint16_t>(data[at] << 8 | data[at + 1]);
}

}  // namespace

OutputPlan OutputPlan::factory() {
  OutputPlan plan;
  plan.items_ = {{kPacketCounter, 0}, {kSampleTimeFine, 0}, {kAcceleration, 4}, {kRateOfTurn, 4}, {kTemperature, 40}};
  return plan;
}

std::optional<OutputPlan> OutputPlan::parse(std::span<const std::uint8_t> data) {
  if (data.size() % kBytesPerItem != 0) return std::nullopt;
  OutputPlan plan;
  for (std::size_t i = 0; i < data.size(); i += kBytesPerItem) {
    const std::uint16_t id = u16_at(data, i);
    const std::uint16_t rate_hz = u16_at(data, i + 2);
    if (comes_with_every_packet(id)) {
      plan.items_.push_back({id, 0});
    } else if (has_a_rate(id) && rate_hz > 0) {
      plan.items_.push_back({id, divider_of(rate_hz)});
    } else {
      return std::nullopt;
    }
  }
  return plan;
}

base::Bytes OutputPlan::data() const {
  base::Bytes data;
  for (const OutputItem& item : items_) {
    append_u16(data, item.id);
    append_u16(data, item.divider > 0 ? static_cast<std::uint16_t>(kTicksPerSecond / item.divider) : kEveryPacket);
  }
  return data;
}

std::optional<Tick> OutputPlan::next_packet(Tick tick) const {
  std::optional<Tick> next;
  for (const OutputItem& item : items_) {
    if (item.divider == 0) continue;
    const Tick due = (tick / item.divider + 1) * item.divider;
    next = std::min(next.value_or(due), due);
  }
  return next;
}

}  // namespace soak::hal::sim
