// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "hal/imu/detail/ahrs400_decoder.h"
#include "hal/imu/detail/vectornav_frame.h"
#include "hal/imu/detail/xsens_frames.h"
#include "tests/hal/ahrs400_peer.h"
#include "tests/hal/vectornav_peer.h"
#include "tests/hal/xsens_golden.h"
#include "tests/hal/xsens_peer.h"

/// The wire of each protocol: its decoder, what a test keeps of a message, and a stream that is hard to decode. For the
/// tests that every decoder must pass (decoders_test.cpp) and for those of one protocol.
namespace soak::hal::imu::test {

struct XbusWire {
  using Decoder = XbusDecoder;
  struct Message {
    std::uint8_t bus;
    unsigned id;
    Bytes data;
    bool operator==(const Message&) const = default;
  };
  static constexpr std::array<std::uint8_t, 6> kSpecialBytes = {0xFA, 0xFF, 0x00, 0x36, 0x1F, 0x01};
  static constexpr std::size_t kMostPending = 8192;
  static constexpr std::size_t kDifficultMessages = 5;

  static Message keep(const XbusMessage& message) {
    return {message.bus, static_cast<unsigned>(message.id), Bytes(message.data.begin(), message.data.end())};
  }
  static std::size_t frame_size(const XbusMessage& message) { return message.frame_size; }
  /// Frames of all kinds with garbage that looks like frames between them.
  static Bytes difficult_stream() {
    return hex("00 FA FF") + frame(0x31) + hex("FA FA FF 36") + golden_with_temperature() +
           frame(0x36, Bytes(300, 0x11)) + hex("FA 00 00 00 00 FA FF 36 FF FF FF") + golden_short() + frame(0x3E);
  }
};

struct VectorNavWire {
  using Decoder = VectorNavDecoder;
  struct Message {
    std::string text;
    VectorNavFields fields;
    Bytes data;
    bool operator==(const Message&) const = default;
  };
  static constexpr std::array<std::uint8_t, 8> kSpecialBytes = {0xFA, '$', 'V', 'N', 0x05, 0x01, '*', '\n'};
  static constexpr std::size_t kMostPending = 500;
  static constexpr std::size_t kDifficultMessages = 5;

  static Message keep(const VectorNavMessage& message) {
    return {std::string(message.text), message.fields, Bytes(message.data.begin(), message.data.end())};
  }
  static std::size_t frame_size(const VectorNavMessage& message) { return message.frame_size; }
  static Bytes difficult_stream() {
    return hex("24 FA FA 05") + golden_vectornav() + text("$VNxx\r\n$$V") + line("VNRRG,03,0100011981") +
           hex("FA 01 FF") + golden_vectornav_ypr() + line("VNWRG,06,0") + hex("FA 05 01 00 10 06 08") +
           golden_vectornav();
  }
};

struct Ahrs400Wire {
  using Decoder = Ahrs400Decoder;
  using Message = std::uint16_t;  ///< its timer
  static constexpr std::array<std::uint8_t, 2> kSpecialBytes = {0xFF, 0xFF};
  static constexpr std::size_t kMostPending = 2 * kAhrs400PacketSize;
  static constexpr std::size_t kDifficultMessages = 8;

  static Message keep(const Ahrs400Packet& packet) { return packet.timer; }
  static std::size_t frame_size(const Ahrs400Packet& /*packet*/) { return kAhrs400PacketSize; }
  /// Packets of rising number in their rates and timers, with FF all over them.
  static Bytes stream(int count, int first = 0) {
    Bytes all;
    for (int i = first; i < first + count; ++i) all = all + ahrs400_packet({i, -1, -1, -256, 255, -1, 0, 0, 0, 0, i});
    return all;
  }
  static Bytes difficult_stream() {
    return hex("12 FF 00") + stream(4) + hex("FF FF FF") + stream(4, 4) + hex("FF 01");
  }
};

/// Takes all messages that a decoder has.
template <class Wire>
void drain(typename Wire::Decoder& decoder, std::vector<typename Wire::Message>& messages) {
  while (const auto message = decoder.next()) messages.push_back(Wire::keep(*message));
}

/// The messages of a stream that comes at once.
template <class Wire>
std::vector<typename Wire::Message> decode(const Bytes& bytes) {
  typename Wire::Decoder decoder;
  std::vector<typename Wire::Message> messages;
  decoder.append(bytes);
  drain<Wire>(decoder, messages);
  return messages;
}

}  // namespace soak::hal::imu::test
