// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The other end of the wire, written from the protocol's description and not from the driver's code.
namespace soak::hal::imu::test {

using Bytes = std::vector<std::uint8_t>;

/// Bytes of "FA FF 36 ...".
inline Bytes hex(std::string_view text) {
  Bytes bytes;
  for (std::size_t i = 0; i < text.size(); i += 3) {
    bytes.push_back(static_cast<std::uint8_t>(std::strtoul(std::string(text.substr(i, 2)).c_str(), nullptr, 16)));
  }
  return bytes;
}

inline Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

inline Bytes frame(unsigned mid, const Bytes& data = {}) {
  Bytes all{0xFA, 0xFF, static_cast<std::uint8_t>(mid)};
  if (data.size() > 254) {
    all = all + Bytes{0xFF, static_cast<std::uint8_t>(data.size() / 256)};
  }
  all.push_back(static_cast<std::uint8_t>(data.size() % 256));
  all = all + data;
  unsigned sum = 0;
  for (std::size_t i = 1; i < all.size(); ++i) sum += all[i];
  all.push_back(static_cast<std::uint8_t>((256 - sum % 256) % 256));
  return all;
}

inline Bytes u16(unsigned value) {
  return {static_cast<std::uint8_t>(value / 256), static_cast<std::uint8_t>(value % 256)};
}
inline Bytes u32(std::uint32_t value) { return u16(value >> 16U) + u16(value & 0xFFFFU); }
inline Bytes f32(float value) { return u32(std::bit_cast<std::uint32_t>(value)); }
inline Bytes item(unsigned id, const Bytes& value) {
  return u16(id) + Bytes{static_cast<std::uint8_t>(value.size())} + value;
}
inline Bytes text(std::string_view value) { return {value.begin(), value.end()}; }

/// A unit that obeys the protocol: takes commands, gives answers and packets.
class ScriptedUnit {
 public:
  std::uint32_t serial = 0x0380ABCD;
  std::string product = "MTi-300-AHRS        ";
  bool answers = true;
  bool measuring = false;
  unsigned error_upon = 0xFFFF;  ///< MID that it answers with an error
  unsigned mute_times = 0;       ///< that many commands it does not hear
  double offered_share = 1.0;    ///< of the rate of turn that it is asked for
  std::vector<unsigned> heard;   ///< MIDs of the commands
  Bytes output_configuration;    ///< as asked for
  std::uint16_t counter = 0;
  std::uint32_t ticks = 0;
  std::uint32_t ticks_per_packet = 100;

  /// Takes bytes from the station, returns the answers.
  Bytes take(std::span<const std::uint8_t> bytes) {
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    Bytes answer;
    while (pending_.size() >= 5 && pending_.size() >= 5U + pending_[3]) {
      const std::size_t size = 5U + pending_[3];
      answer = answer + obey(pending_[2], Bytes(pending_.begin() + 4, pending_.begin() + static_cast<long>(size) - 1));
      pending_.erase(pending_.begin(), pending_.begin() + static_cast<long>(size));
    }
    return answer;
  }

  /// The next packet: at 100 Hz unless told otherwise, a temperature with every tenth, values that tell the packet's
  /// number.
  Bytes packet() {
    const float number = static_cast<float>(counter);
    Bytes data = item(0x1020, u16(counter)) + item(0x1060, u32(ticks)) +
                 item(0x4020, f32(number) + f32(-number) + f32(9.8F)) +
                 item(0x8020, f32(0.5F * number) + f32(0.25F) + f32(-0.125F));
    if (counter % 10 == 0) data = data + item(0x0810, f32(20.0F + number));
    data = data + item(0xE020, u32(0x00400003));
    ++counter;
    ticks += ticks_per_packet;
    return frame(0x36, data);
  }

  Bytes packets(int count) {
    Bytes all;
    for (int i = 0; i < count; ++i) all = all + packet();
    return all;
  }

  /// Power off and on: returns the wake-up message.
  Bytes restart() {
    counter = 0;
    ticks = 0;
    measuring = false;
    pending_.clear();
    return frame(0x3E);
  }

 private:
  Bytes obey(unsigned mid, const Bytes& data) {
    heard.push_back(mid);
    if (!answers) return {};
    if (mute_times > 0) {
      --mute_times;
      return {};
    }
    if (mid == error_upon) return frame(0x42, {0x21});
    switch (mid) {
      case 0x30:
        measuring = false;
        return frame(0x31);
      case 0x00:
        return frame(0x01, u32(serial));
      case 0x1C:
        return frame(0x1D, text(product));
      case 0x12:
        return frame(0x13, {1, 8, 2, 0, 0, 0, 7});
      case 0xC0:
        output_configuration = data;
        return frame(0xC1, offer(data));
      case 0x10:
        measuring = true;
        return frame(0x11);
      default:
        return {};
    }
  }

  [[nodiscard]] Bytes offer(Bytes configuration) const {
    for (std::size_t i = 0; i + 4 <= configuration.size(); i += 4) {
      if (configuration[i] != 0x80) continue;
      const unsigned asked = configuration[i + 2] * 256U + configuration[i + 3];
      const Bytes offered = u16(static_cast<unsigned>(asked * offered_share));
      configuration[i + 2] = offered[0];
      configuration[i + 3] = offered[1];
    }
    return configuration;
  }

  Bytes pending_;
};

}  // namespace soak::hal::imu::test
