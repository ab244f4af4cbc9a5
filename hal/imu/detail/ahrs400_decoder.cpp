// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/ahrs400_decoder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace soak::hal::imu {

// --- packets

namespace {

constexpr std::uint8_t kAhrs400Header = 0xFF;
constexpr std::size_t kAhrs400Rate = 1;
constexpr std::size_t kAhrs400Accel = 7;
constexpr std::size_t kAhrs400Temp = 19;
constexpr std::size_t kAhrs400Timer = 21;
constexpr std::size_t kAhrs400Sum = 23;

/// `bytes` begins with a whole packet, and with the header of another one where they go on.
bool is_good_packet(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kAhrs400PacketSize || bytes[0] != kAhrs400Header) return false;
  if (bytes.size() > kAhrs400PacketSize && bytes[kAhrs400PacketSize] != kAhrs400Header) return false;
  const auto numbers = bytes.subspan(1, kAhrs400Sum - 1);
  return static_cast<std::uint8_t>(std::accumulate(numbers.begin(), numbers.end(), 0U)) == bytes[kAhrs400Sum];
}

std::array<std::int16_t, 3> read_three_numbers(const std::uint8_t* bytes) {
  std::array<std::int16_t, 3> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = static_cast<std::int16_t>(big_endian<std::uint16_t>(bytes + 2 * i));
  }
  return numbers;
}

}  // namespace

std::optional<Ahrs400Packet> Ahrs400Decoder::next() {
  for (;;) {
    if (in_step_) {
      if (pending().size() < kAhrs400PacketSize) return std::nullopt;
      if (is_good_packet(pending())) return take();
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
    skip_until([](std::uint8_t byte) { return byte == kAhrs400Header; });
    if (pending_bytes() < kAhrs400PacketSize) return;
    if (is_good_packet(pending())) {
      if (pending_bytes() < 2 * kAhrs400PacketSize) return;
      in_step_ = is_good_packet(pending().subspan(kAhrs400PacketSize));
      if (in_step_) return;
    }
    skip_garbage(1);
  }
}

Ahrs400Packet Ahrs400Decoder::take() {
  const std::uint8_t* bytes = pending().data();
  Ahrs400Packet packet;
  packet.rate = read_three_numbers(bytes + kAhrs400Rate);
  packet.accel = read_three_numbers(bytes + kAhrs400Accel);
  packet.temp = big_endian<std::uint16_t>(bytes + kAhrs400Temp);
  packet.timer = big_endian<std::uint16_t>(bytes + kAhrs400Timer);
  packet.after_loss = std::exchange(after_loss_, false);
  take_frame(kAhrs400PacketSize);
  return packet;
}

bool Ahrs400Decoder::drop_partial() {
  in_step_ = in_step_ && pending_bytes() == 0;
  after_loss_ = after_loss_ || pending_bytes() > 0;
  return FrameDecoder::drop_partial();
}

void Ahrs400Decoder::clear() {
  FrameDecoder::clear();
  in_step_ = false;
  after_loss_ = true;
}

// --- the time

namespace {

/// Packets come every 14 ms or so: nothing for this long is a silence, and leaves no doubt below one wrap.
constexpr double kSilence_s = 0.045;
/// By how much the unit's clock may lag behind the host's without a gap: the step of 0.79 µs is rounded, and the unit's
/// crystal and the host's have tolerances of their own.
constexpr double kDrift = 0.02;

double seconds_of(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

std::vector<std::uint64_t> Ahrs400Clock::take(std::span<const Stamp> stamps, HostTime now, bool drained) {
  std::vector<std::uint64_t> steps;
  steps.reserve(stamps.size());
  if (stamps.empty()) return steps;
  const bool first = !timer_;
  std::uint64_t batch = 0;
  for (const Stamp& stamp : stamps) {
    steps.push_back(timer_ ? static_cast<std::uint16_t>(*timer_ - stamp.timer) : 0U);
    // The first step is no part of the batch: it lies before it.
    if (steps.size() > 1) batch += steps.back();
    ticks_ += steps.back();
    timer_ = stamp.timer;
  }
  if (!drained) {
    gap_open_ = gap_open_ || std::any_of(stamps.begin(), stamps.end(), [](const Stamp& s) { return s.after_loss; });
    return steps;
  }
  if (first || !began_) {
    began_ = heard_ = now;
    best_offset_s_ = -kTick_s * static_cast<double>(ticks_);
    gap_open_ = false;
    return steps;
  }
  const double silence_s = seconds_of(now - heard_);
  heard_ = now;
  double offset_s = seconds_of(now - *began_) - kTick_s * static_cast<double>(ticks_);
  const auto wraps = std::lround((offset_s - best_offset_s_) / kWrap_s);
  const auto place = place_of_gap(stamps, kTick_s * static_cast<double>(batch), silence_s);
  // A batch that was late and has no break may have been cut off at its end, by a buffer that was full.
  gap_open_ = wraps > 0 && !place;
  if (gap_open_) return steps;
  if (wraps > 0) {
    const std::uint64_t missing = static_cast<std::uint64_t>(wraps) << 16U;
    steps[*place] += missing;
    ticks_ += missing;
    offset_s -= kWrap_s * static_cast<double>(wraps);
  }
  follow_host(offset_s, silence_s);
  return steps;
}

std::optional<std::size_t> Ahrs400Clock::place_of_gap(std::span<const Stamp> stamps, double batch_s,
                                                      double silence_s) const {
  const auto loss = std::find_if(stamps.begin(), stamps.end(), [](const Stamp& stamp) { return stamp.after_loss; });
  if (loss != stamps.end()) return static_cast<std::size_t>(loss - stamps.begin());
  const bool paused = silence_s > kSilence_s && batch_s < kSilence_s;
  if (gap_open_ || paused) return 0;
  return std::nullopt;
}

void Ahrs400Clock::follow_host(double offset_s, double elapsed_s) {
  best_offset_s_ = std::min(offset_s, best_offset_s_ + kDrift * elapsed_s);
}

}  // namespace soak::hal::imu
