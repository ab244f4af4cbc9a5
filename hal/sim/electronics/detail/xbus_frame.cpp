// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_frame.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace soak::hal::sim {
namespace {

constexpr std::uint8_t kPreamble = 0xFA;
constexpr std::uint8_t kBusId = 0xFF;
constexpr std::uint8_t kExtended = 0xFF;
constexpr std::size_t kMaxShort = 254;
constexpr std::size_t kMaxData = 8192 - 7;

/// Sum modulo 256.
std::uint8_t sum_of(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return static_cast<std::uint8_t>(sum);
}

/// Where the data of a frame lie.
struct Extent {
  std::size_t start = 0;
  std::size_t length = 0;
};

/// Nothing while the header is incomplete.
std::optional<Extent> extent_of(std::span<const std::uint8_t> frame) {
  if (frame.size() < 4) return std::nullopt;
  if (frame[3] != kExtended) return Extent{4, frame[3]};
  if (frame.size() < 6) return std::nullopt;
  return Extent{6, static_cast<std::size_t>(frame[4]) << 8 | frame[5]};
}

}  // namespace

base::Bytes xbus_frame(std::uint8_t id, std::span<const std::uint8_t> data) {
  base::Bytes frame = {kPreamble, kBusId, id};
  if (data.size() > kMaxShort) {
    frame.push_back(kExtended);
    append_u16(frame, static_cast<std::uint16_t>(data.size()));
  } else {
    frame.push_back(static_cast<std::uint8_t>(data.size()));
  }
  frame.insert(frame.end(), data.begin(), data.end());
  frame.push_back(static_cast<std::uint8_t>(-sum_of(std::span(frame).subspan(1))));
  return frame;
}

void append_u16(base::Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

void append_u32(base::Bytes& bytes, std::uint32_t value) {
  append_u16(bytes, static_cast<std::uint16_t>(value >> 16));
  append_u16(bytes, static_cast<std::uint16_t>(value));
}

void append_f32(base::Bytes& bytes, float value) { append_u32(bytes, std::bit_cast<std::uint32_t>(value)); }

std::optional<XbusMessage> XbusParser::next() {
  while (true) {
    pending_.erase(pending_.begin(), std::find(pending_.begin(), pending_.end(), kPreamble));
    const auto extent = extent_of(pending_);
    if (!extent) return std::nullopt;
    const std::size_t end = extent->start + extent->length + 1;
    if (extent->length <= kMaxData && pending_.size() < end) return std::nullopt;
    const bool intact = extent->length <= kMaxData && sum_of(std::span(pending_).subspan(1, end - 1)) == 0;
    if (!intact) {
      pending_.erase(pending_.begin());
      continue;
    }
    XbusMessage message;
    message.id = pending_[2];
    const auto data = std::span(pending_).subspan(extent->start, extent->length);
    message.data.assign(data.begin(), data.end());
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(end));
    return message;
  }
}

}  // namespace soak::hal::sim
