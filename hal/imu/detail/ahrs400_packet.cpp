// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/ahrs400_packet.h"

#include <cstring>
#include <numeric>
#include <utility>

#include "hal/imu/detail/big_endian.h"

namespace soak::hal::imu {
namespace {

constexpr std::uint8_t kHeader = 0xFF;
constexpr std::size_t kRate = 1;
constexpr std::size_t kAccel = 7;
constexpr std::size_t kTemp = 19;
constexpr std::size_t kTimer = 21;
constexpr std::size_t kSum = 23;

/// `bytes` begins with a whole packet, and with the header of another one where they go on.
bool is_good(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kAhrs400PacketSize || bytes[0] != kHeader) return false;
  if (bytes.size() > kAhrs400PacketSize && bytes[kAhrs400PacketSize] != kHeader) return false;
  const auto numbers = bytes.subspan(1, kSum - 1);
  return static_cast<std::uint8_t>(std::accumulate(numbers.begin(), numbers.end(), 0U)) == bytes[kSum];
}

std::array<std::int16_t, 3> read_three(const std::uint8_t* bytes) {
  std::array<std::int16_t, 3> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = static_cast<std::int16_t>(big_endian<std::uint16_t>(bytes + 2 * i));
  }
  return numbers;
}

}  // namespace

void Ahrs400Decoder::append(std::span<const std::uint8_t> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Ahrs400Packet> Ahrs400Decoder::next() {
  for (;;) {
    if (in_step_) {
      if (pending().size() < kAhrs400PacketSize) return std::nullopt;
      if (is_good(pending())) return take();
      in_step_ = false;
      after_loss_ = true;
      skip_garbage(1);
    }
    search();
    if (!in_step_) return std::nullopt;
  }
}

void Ahrs400Decoder::search() {
  while (pending_bytes() > 0) {
    const auto* header = static_cast<const std::uint8_t*>(std::memchr(pending().data(), kHeader, pending_bytes()));
    skip_garbage(header == nullptr ? pending_bytes() : static_cast<std::size_t>(header - pending().data()));
    if (pending_bytes() < kAhrs400PacketSize) return;
    if (is_good(pending())) {
      if (pending_bytes() < 2 * kAhrs400PacketSize) return;
      in_step_ = is_good(pending().subspan(kAhrs400PacketSize));
      if (in_step_) return;
    }
    skip_garbage(1);
  }
}

Ahrs400Packet Ahrs400Decoder::take() {
  const std::uint8_t* bytes = pending().data();
  Ahrs400Packet packet;
  packet.rate = read_three(bytes + kRate);
  packet.accel = read_three(bytes + kAccel);
  packet.temp = big_endian<std::uint16_t>(bytes + kTemp);
  packet.timer = big_endian<std::uint16_t>(bytes + kTimer);
  packet.after_loss = std::exchange(after_loss_, false);
  begin_ += kAhrs400PacketSize;
  return packet;
}

bool Ahrs400Decoder::drop_partial() {
  if (pending_bytes() == 0) return false;
  in_step_ = false;
  after_loss_ = true;
  skip_garbage(1);
  return true;
}

void Ahrs400Decoder::clear() {
  buffer_.clear();
  begin_ = 0;
  in_step_ = false;
  after_loss_ = true;
}

void Ahrs400Decoder::skip_garbage(std::size_t count) {
  begin_ += count;
  garbage_bytes_ += count;
}

}  // namespace soak::hal::imu
