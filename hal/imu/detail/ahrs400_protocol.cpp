// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/ahrs400_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/units.h"

namespace soak::hal::imu {
namespace {

constexpr double kHighestRate_hz = 70.0;
/// The longest step between packets is 20 ms or so; a byte takes 0.3 ms.
constexpr auto kEndOfAnswer = std::chrono::milliseconds(100);
constexpr auto kIdle = std::chrono::milliseconds(300);
/// So many bytes are decoded although more waits: a flood from something else must not fill the memory.
constexpr std::size_t kMostUndecoded = 256U << 10U;
constexpr std::size_t kMostAnswer = 256;
constexpr double kShareOfNewStep = 1.0 / 16.0;

/// Printable characters of an answer.
std::string ahrs400_text(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte >= 0x20 && byte < 0x7F) text.push_back(static_cast<char>(byte));
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

base::Status Ahrs400Protocol::check(const Imu::Settings& settings) const {
  if (settings.rate_hz < 1.0 || settings.rate_hz > kHighestRate_hz) {
    return base::bad_input(
        fmt::format("an AHRS400 sends at most {} packets a second, at a rate of its own: ask for 1 to {} Hz, not {}",
                    kHighestRate_hz, kHighestRate_hz, settings.rate_hz));
  }
  if (!(settings.temp_rate_hz > 0.0)) return base::bad_input("the temperature rate must be above 0 Hz");
  return {};
}

// --- the stream of bytes

void Ahrs400Protocol::append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point now,
                             bool drained) {
  if (step_ != Step::done && step_ != Step::listen) {
    answer_.insert(answer_.end(), bytes.begin(), bytes.end());
    // Of a stream that does not end only the end can be an answer.
    if (answer_.size() > kMostAnswer) answer_.erase(answer_.begin(), answer_.end() - kMostAnswer);
    return;
  }
  decoder_.append(bytes);
  if (drained || decoder_.pending_bytes() > kMostUndecoded) decode(now, drained);
}

void Ahrs400Protocol::decode(std::chrono::steady_clock::time_point now, bool drained) {
  std::vector<Ahrs400Packet> packets;
  while (const auto packet = decoder_.next()) packets.push_back(*packet);
  if (step_ == Step::listen) {
    heard_stream_ = heard_stream_ || packets.size() >= 2;
    return;
  }
  std::vector<Ahrs400Clock::Stamp> stamps;
  stamps.reserve(packets.size());
  for (const Ahrs400Packet& packet : packets) stamps.push_back({packet.timer, packet.after_loss});
  const auto steps = clock_.take(stamps, now, drained);
  for (std::size_t i = 0; i < packets.size(); ++i) packets_.push_back({packets[i], steps[i]});
}

base::Result<std::optional<Protocol::Heard>> Ahrs400Protocol::next() {
  if (step_ == Step::listen && heard_stream_) {
    found_idle_ = false;
    step_ = Step::ping;
    return Heard::answer;
  }
  if (packets_.empty()) return std::nullopt;
  current_ = packets_.front();
  packets_.pop_front();
  fill_packet(current_.packet);
  return Heard::packet;
}

bool Ahrs400Protocol::drop_partial() { return decoder_.drop_partial(); }

void Ahrs400Protocol::clear() {
  decoder_.clear();
  packets_.clear();
  answer_.clear();
}

// --- the dialogue

void Ahrs400Protocol::begin(const Imu::Settings& /*settings*/) {
  if (step_ == Step::done) {
    step_ = Step::listen;
    heard_stream_ = false;
    found_idle_ = false;
  } else {
    // The first request has stopped the unit already: whether it streamed is known from then.
    step_ = Step::ping;
  }
  identity_ = {};
  passed_over_ += decoder_.pending_bytes();
  packets_.clear();
  decoder_.clear();
}

base::Bytes Ahrs400Protocol::request() {
  answer_.clear();
  switch (step_) {
    case Step::ping:
      return {'R'};
    case Step::serial:
      return {'S'};
    case Step::version:
      return {'v'};
    case Step::scaled:
      return {'c'};
    default:
      return {};
  }
}

std::string_view Ahrs400Protocol::request_name() const {
  switch (step_) {
    case Step::listen:
    case Step::ping:
      return "the ping (R)";
    case Step::serial:
      return "the request for its serial number (S)";
    case Step::version:
      return "the request for its version (v)";
    default:
      return "the request for scaled mode (c)";
  }
}

base::Result<bool> Ahrs400Protocol::end_answer(std::chrono::steady_clock::duration quiet) {
  if (step_ == Step::done) return false;
  if (step_ == Step::listen) {
    if (quiet < kIdle) return false;
    found_idle_ = told_to_stream_;
    step_ = Step::ping;
    return true;
  }
  if (quiet < kEndOfAnswer || answer_.empty()) return false;
  if (!take_answer()) {
    passed_over_ += answer_.size();
    answer_.clear();
    return false;
  }
  step_ = static_cast<Step>(static_cast<std::uint8_t>(step_) + 1);
  if (step_ == Step::done) {
    told_to_stream_ = true;
    // The voltages' packets, if any, are no part of the stream.
    decoder_.clear();
    packets_.clear();
  }
  return true;
}

bool Ahrs400Protocol::take_answer() {
  switch (step_) {
    case Step::ping:
      // Behind the rest of a stream that it has stopped.
      return answer_.back() == 'H';
    case Step::serial:
      return take_serial();
    case Step::version:
      identity_.product = ahrs400_text(answer_);
      identity_.simulated = identity_.product.find("SIMULATED") != std::string::npos;
      return !identity_.product.empty();
    default:
      return answer_.size() == 1 && answer_.front() == 'C';
  }
}

/// FF, number, sum of the number's bytes (VG700 manual) or the number alone (AHRS400 quick reference).
bool Ahrs400Protocol::take_serial() {
  constexpr std::size_t kNumber = 4;
  std::span<const std::uint8_t> number = answer_;
  if (number.size() == kNumber + 2) {
    number = number.subspan(1, kNumber);
    const auto sum = static_cast<std::uint8_t>(std::accumulate(number.begin(), number.end(), 0U));
    if (answer_.front() != 0xFF || answer_.back() != sum) return false;
  }
  if (number.size() != kNumber) return false;
  identity_.serial = fmt::format("{}", big_endian<std::uint32_t>(number.data()));
  return true;
}

base::Bytes Ahrs400Protocol::start_command() const { return told_to_stream_ ? base::Bytes{'C'} : base::Bytes{}; }

void Ahrs400Protocol::assume_done(const Imu::Settings& /*settings*/) {
  step_ = Step::done;
  told_to_stream_ = false;
}

std::chrono::steady_clock::duration Ahrs400Protocol::silence_limit() const { return std::chrono::seconds(3); }

// --- measurements and the unit's clock

void Ahrs400Protocol::fill_packet(const Ahrs400Packet& packet) {
  packet_ = {};
  packet_.stamped = true;
  packet_.measured = true;
  packet_.counter = packet.timer;
  packet_.temp_c = ahrs400_temp_c(packet.temp);
  for (std::size_t i = 0; i < 3; ++i) {
    packet_.rate_rps[i] = static_cast<float>(ahrs400_scaled(packet.rate[i], ranges_.rate_dps) / base::kDegPerRad);
    packet_.accel_mps2[i] =
        static_cast<float>(ahrs400_scaled(packet.accel[i], ranges_.accel_g) * base::kStandardGravity_mps2);
    packet_.clipped = packet_.clipped || at_rail(packet.rate[i]) || at_rail(packet.accel[i]);
  }
}

bool Ahrs400Protocol::advance() {
  lost_packets_ = 0;
  const bool interrupted = std::exchange(interrupted_, false);
  if (has_time_) {
    ticks_ += current_.step;
    if (!interrupted) count_loss();
  }
  has_time_ = true;
  return true;
}

void Ahrs400Protocol::count_loss() {
  // The packet before, sent again: its step is none of the unit's.
  if (current_.step == 0) return;
  const auto step = static_cast<double>(current_.step);
  if (mean_step_ > 0.0) {
    lost_packets_ = static_cast<std::uint32_t>(std::max(0L, std::lround(std::min(step / mean_step_, 1e9)) - 1));
  }
  if (current_.packet.after_loss || lost_packets_ > 0) return;
  mean_step_ += mean_step_ > 0.0 ? kShareOfNewStep * (step - mean_step_) : step;
}

void Ahrs400Protocol::restart_clock() {
  clock_.clear();
  ticks_ = 0;
  has_time_ = false;
  lost_packets_ = 0;
}

}  // namespace soak::hal::imu
