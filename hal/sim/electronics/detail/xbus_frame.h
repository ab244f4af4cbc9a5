// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/bytes.h"

namespace soak::hal::sim {

/// A message of the Xbus protocol.
struct XbusMessage {
  std::uint8_t id = 0;
  base::Bytes data;
};

/// FA FF id length data checksum: all bytes after FA add up to 0 modulo 256. Data longer than 254 bytes take the
/// extended length FF + 16 bits.
[[nodiscard]] base::Bytes xbus_frame(std::uint8_t id, std::span<const std::uint8_t> data);

/// Numbers of a message are big-endian.
void append_u16(base::Bytes& bytes, std::uint16_t value);
void append_u32(base::Bytes& bytes, std::uint32_t value);
void append_f32(base::Bytes& bytes, float value);

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

}  // namespace soak::hal::sim
