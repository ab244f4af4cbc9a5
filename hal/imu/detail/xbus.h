// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/bytes.h"

namespace soak::hal::imu {

/// Message identifiers of the Xbus protocol; the answer to a request has the next number.
enum class Mid : std::uint8_t {
  request_device_id = 0x00,
  request_product_code = 0x1C,
  request_firmware = 0x12,
  go_to_measurement = 0x10,
  go_to_config = 0x30,
  mt_data2 = 0x36,
  wake_up = 0x3E,
  wake_up_ack = 0x3F,
  error = 0x42,
  set_output_configuration = 0xC0,
};

[[nodiscard]] constexpr Mid answer_to(Mid request) { return static_cast<Mid>(static_cast<std::uint8_t>(request) + 1); }

/// Most data bytes that a message may have.
inline constexpr std::size_t kMaxXbusData = 8192 - 7;

/// A message whose frame was valid; the data belong to the decoder.
struct XbusMessage {
  std::uint8_t bus = 0;
  Mid id{};
  std::span<const std::uint8_t> data;
  std::size_t frame_size = 0;  ///< with preamble, header and checksum
};

/// Frame FA, bus FF, MID, length, data, checksum: the sum of all bytes after FA is 0 modulo 256. At most kMaxXbusData
/// bytes of data; from 255 on the length takes the extended form FF, high byte, low byte.
[[nodiscard]] base::Bytes encode_xbus(Mid id, std::span<const std::uint8_t> data = {});

/// Finds the messages in a stream of bytes that may be split and damaged anywhere. Behind a frame that does not hold it
/// goes on with the byte after that frame's FA, so that a true frame which begins inside a false one is found. The
/// checksum is a sum: every single wrong byte shows; two that compensate each other, and bytes that changed places, do
/// not. Keeps at most one incomplete frame besides what the last append() brought.
class XbusDecoder {
 public:
  /// Takes bytes. next() is to be called until it has no more before the next append().
  void append(std::span<const std::uint8_t> bytes);
  /// The next message; its data are valid until the next call of any kind.
  [[nodiscard]] std::optional<XbusMessage> next();
  /// Gives up the frame that has begun but does not end (a false FA may announce thousands of bytes that never come);
  /// next() may then find messages behind it. False if nothing was pending.
  bool drop_partial();
  void clear();

  [[nodiscard]] std::uint64_t garbage_bytes() const { return garbage_bytes_; }
  [[nodiscard]] std::size_t pending_bytes() const { return buffer_.size() - begin_; }

 private:
  void skip_to_preamble();
  void skip_garbage(std::size_t count);

  base::Bytes buffer_;
  std::size_t begin_ = 0;  ///< of what is not yet decoded
  std::uint64_t garbage_bytes_ = 0;
};

}  // namespace soak::hal::imu
