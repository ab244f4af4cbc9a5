// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xbus.h"

#include <cstring>
#include <numeric>

namespace soak::hal::imu {
namespace {

constexpr std::uint8_t kPreamble = 0xFA;
constexpr std::uint8_t kBus = 0xFF;
constexpr std::uint8_t kExtended = 0xFF;
constexpr std::size_t kShortHeader = 4;
constexpr std::size_t kLongHeader = 6;

std::uint8_t sum_of(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), 0U));
}

/// What the bytes from an FA on say about the frame.
struct Header {
  enum class Kind { incomplete, impossible, found } kind;
  std::size_t header_size = 0;
  std::size_t data_size = 0;

  [[nodiscard]] std::size_t frame_size() const { return header_size + data_size + 1; }
};

Header read_header(std::span<const std::uint8_t> bytes) {
  using enum Header::Kind;
  if (bytes.size() < kShortHeader) return {incomplete};
  // Zeros behind an FA are no message: no device has bus 0, and request 0 comes from the host alone.
  if (bytes[1] == 0 && bytes[2] == 0) return {impossible};
  if (bytes[3] != kExtended) return {found, kShortHeader, bytes[3]};
  if (bytes.size() < kLongHeader) return {incomplete};
  const std::size_t size = static_cast<std::size_t>(bytes[4]) << 8U | bytes[5];
  return size > kMaxXbusData ? Header{impossible} : Header{found, kLongHeader, size};
}

}  // namespace

base::Bytes encode_xbus(Mid id, std::span<const std::uint8_t> data) {
  base::Bytes frame;
  frame.reserve(kLongHeader + data.size() + 1);
  for (const std::uint8_t byte : {kPreamble, kBus, static_cast<std::uint8_t>(id)}) frame.push_back(byte);
  if (data.size() >= kExtended) {
    frame.push_back(kExtended);
    frame.push_back(static_cast<std::uint8_t>(data.size() >> 8U));
  }
  frame.push_back(static_cast<std::uint8_t>(data.size()));
  frame.insert(frame.end(), data.begin(), data.end());
  frame.push_back(static_cast<std::uint8_t>(0U - sum_of(std::span(frame).subspan(1))));
  return frame;
}

void XbusDecoder::append(std::span<const std::uint8_t> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<XbusMessage> XbusDecoder::next() {
  for (;;) {
    skip_to_preamble();
    const auto pending = std::span<const std::uint8_t>(buffer_).subspan(begin_);
    const Header header = read_header(pending);
    if (header.kind == Header::Kind::incomplete) return std::nullopt;
    if (header.kind == Header::Kind::found) {
      if (pending.size() < header.frame_size()) return std::nullopt;
      if (sum_of(pending.subspan(1, header.frame_size() - 1)) == 0) {
        begin_ += header.frame_size();
        return XbusMessage{pending[1], static_cast<Mid>(pending[2]),
                           pending.subspan(header.header_size, header.data_size), header.frame_size()};
      }
    }
    skip_garbage(1);
  }
}

bool XbusDecoder::drop_partial() {
  if (pending_bytes() == 0) return false;
  skip_garbage(1);
  return true;
}

void XbusDecoder::clear() {
  buffer_.clear();
  begin_ = 0;
}

void XbusDecoder::skip_to_preamble() {
  if (pending_bytes() == 0) return;
  const std::uint8_t* first = buffer_.data() + begin_;
  const auto* preamble = static_cast<const std::uint8_t*>(std::memchr(first, kPreamble, pending_bytes()));
  skip_garbage(preamble == nullptr ? pending_bytes() : static_cast<std::size_t>(preamble - first));
}

void XbusDecoder::skip_garbage(std::size_t count) {
  begin_ += count;
  garbage_bytes_ += count;
}

}  // namespace soak::hal::imu
