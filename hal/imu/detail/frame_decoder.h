// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/bytes.h"

namespace soak::hal::imu {

/// The number whose most significant byte stands first at `bytes`; the caller has checked that all are there.
template <std::unsigned_integral T>
[[nodiscard]] T big_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8U | bytes[i];
  return static_cast<T>(value);
}

/// What all decoders have in common that find frames in a stream which may be split and damaged anywhere: the bytes
/// that are not decoded yet, and how many belonged to no frame. A decoder adds next(), which is to be called until it
/// has no more before the next append().
class FrameDecoder {
 public:
  void append(std::span<const std::uint8_t> bytes) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  /// Gives up the frame that has begun but does not end (a false start may announce thousands of bytes that never
  /// come); next() may then find messages behind its first byte. False if nothing was pending.
  bool drop_partial() {
    if (pending_bytes() == 0) return false;
    skip_garbage(1);
    return true;
  }
  void clear() {
    buffer_.clear();
    begin_ = 0;
  }

  [[nodiscard]] std::uint64_t garbage_bytes() const { return garbage_bytes_; }
  [[nodiscard]] std::size_t pending_bytes() const { return buffer_.size() - begin_; }

 protected:
  [[nodiscard]] std::span<const std::uint8_t> pending() const { return std::span(buffer_).subspan(begin_); }
  /// Passes over a frame; its bytes stay where they are until the next append().
  void take_frame(std::size_t size) { begin_ += size; }
  void skip_garbage(std::size_t count) {
    begin_ += count;
    garbage_bytes_ += count;
  }
  /// Moves to the next byte that may begin a frame, or to the end.
  template <class Begins>
  void skip_until(Begins begins) {
    const auto bytes = pending();
    skip_garbage(static_cast<std::size_t>(std::find_if(bytes.begin(), bytes.end(), begins) - bytes.begin()));
  }

 private:
  base::Bytes buffer_;
  std::size_t begin_ = 0;  ///< of what is not yet decoded
  std::uint64_t garbage_bytes_ = 0;
};

}  // namespace soak::hal::imu
