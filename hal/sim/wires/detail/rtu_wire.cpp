// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "hal/sim/wires/detail/chamber_wire.h"

namespace soak::hal::sim {
namespace {

constexpr std::uint8_t kUnit = 1;
constexpr std::uint8_t kReadRegisters = 3;
constexpr std::uint8_t kWriteOne = 6;
constexpr std::uint8_t kWriteMany = 16;
constexpr std::uint8_t kExceptionFlag = 0x80;
constexpr std::size_t kCrc = 2;
constexpr std::size_t kFixedRequest = 8;
constexpr std::size_t kWriteHeader = 7;  // of function 16, up to its byte count
constexpr int kMaxRead = 125;
/// Silence that ends a frame. A pseudo-terminal has no characters' time: this is what a busy machine may pause in one.
constexpr std::int64_t kSilence_ns = 200'000'000;

std::int64_t host_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void append_u16(base::Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
}

/// Size of the request that begins so; nothing = not yet known, 0 = no request that is answered here.
std::optional<std::size_t> request_size(std::span<const std::uint8_t> start) {
  if (start.size() < 2) return std::nullopt;
  if (start[1] == kReadRegisters || start[1] == kWriteOne) return kFixedRequest;
  if (start[1] != kWriteMany) return 0;
  if (start.size() < kWriteHeader) return std::nullopt;
  return kWriteHeader + start[kWriteHeader - 1] + kCrc;
}

ModbusAnswer read_registers(const RegisterTable& registers, std::span<const std::uint8_t> request,
                            base::Bytes& answer) {
  const int count = u16_at(request, 4);
  if (count < 1 || count > kMaxRead) return ModbusAnswer::illegal_value;
  std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
  const ModbusAnswer done = registers.read(u16_at(request, 2), words);
  if (done != ModbusAnswer::done) return done;
  answer.push_back(static_cast<std::uint8_t>(2 * count));
  for (const std::uint16_t word : words) append_u16(answer, word);
  return done;
}

ModbusAnswer write_registers(RegisterTable& registers, std::span<const std::uint8_t> request, base::Bytes& answer) {
  std::vector<std::uint16_t> words;
  if (request[1] == kWriteOne) {
    words.push_back(u16_at(request, 4));
  } else {
    if (request[kWriteHeader - 1] != 2 * u16_at(request, 4)) return ModbusAnswer::illegal_value;
    for (std::size_t at = kWriteHeader; at + kCrc < request.size(); at += 2) words.push_back(u16_at(request, at));
  }
  const ModbusAnswer done = registers.write(u16_at(request, 2), words);
  answer.insert(answer.end(), request.begin() + 2, request.begin() + 6);
  return done;
}

}  // namespace

std::uint16_t rtu_crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

base::Result<std::unique_ptr<RtuWire>> RtuWire::open(RegisterTable registers) {
  std::unique_ptr<RtuWire> wire(new RtuWire(std::move(registers)));
  auto port = PtyUnitPort::open([it = wire.get()](std::span<const std::uint8_t> bytes) { it->receive(bytes); });
  if (!port) return base::forward_error(port);
  wire->port_ = *std::move(port);
  return wire;
}

void RtuWire::receive(std::span<const std::uint8_t> bytes) {
  const std::int64_t now_ns = host_ns();
  if (now_ns - last_byte_ns_ > kSilence_ns) received_.clear();
  last_byte_ns_ = now_ns;
  received_.insert(received_.end(), bytes.begin(), bytes.end());
  const auto size = request_size(received_);
  if (!size || received_.size() < *size) return;
  const base::Bytes frame = std::exchange(received_, {});
  // More than one frame at once is none: a master waits for its answer.
  if (*size != frame.size() || *size <= kCrc) return;
  const std::span<const std::uint8_t> body = std::span(frame).first(frame.size() - kCrc);
  const auto sent = static_cast<std::uint16_t>(frame[frame.size() - 2] | frame[frame.size() - 1] << 8);
  if (rtu_crc(body) == sent && frame[0] == kUnit) answer(frame);
}

void RtuWire::answer(std::span<const std::uint8_t> request) {
  base::Bytes reply = {kUnit, request[1]};
  const ModbusAnswer done = request[1] == kReadRegisters ? read_registers(registers_, request, reply)
                                                         : write_registers(registers_, request, reply);
  if (done != ModbusAnswer::done) {
    reply = {kUnit, static_cast<std::uint8_t>(request[1] | kExceptionFlag), static_cast<std::uint8_t>(done)};
  }
  const std::uint16_t crc = rtu_crc(reply);
  reply.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  reply.push_back(static_cast<std::uint8_t>(crc >> 8));
  port_->queue(reply);
  port_->flush();
}

}  // namespace soak::hal::sim
