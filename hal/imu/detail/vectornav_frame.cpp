// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/vectornav_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace soak::hal::imu {
namespace {

constexpr std::uint8_t kBinaryStart = 0xFA;
constexpr std::uint8_t kTextStart = '$';
constexpr std::uint8_t kCommonGroup = 0x01;
constexpr std::uint8_t kImuGroup = 0x04;
constexpr std::size_t kCrcSize = 2;
constexpr std::size_t kLongestLine = 256;

/// Bytes of each field (VN-100 manual; 0 = no such field).
constexpr std::array<std::uint8_t, 16> kCommonSizes = {8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8, 0};
constexpr std::array<std::uint8_t, 16> kImuSizes = {2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2, 40, 0, 0, 0};

constexpr std::array<std::uint16_t, 256> make_crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U);
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

constexpr auto kCrcTable = make_crc_table();

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::uint8_t exclusive_or(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<std::uint8_t>(c);
  return static_cast<std::uint8_t>(sum);
}

template <class T>
T little_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = sizeof(T); i > 0; --i) value = value << 8U | bytes[i - 1];
  return static_cast<T>(value);
}

float read_float(const std::uint8_t* bytes) { return std::bit_cast<float>(little_endian<std::uint32_t>(bytes)); }

std::array<float, 3> read_three_floats(const std::uint8_t* bytes) {
  return {read_float(bytes), read_float(bytes + 4), read_float(bytes + 8)};
}

/// Bytes of the fields that `mask` names; nothing if it names one that does not exist.
std::optional<std::size_t> size_of(std::uint16_t mask, const std::array<std::uint8_t, 16>& sizes) {
  std::size_t total = 0;
  for (std::size_t bit = 0; bit < sizes.size(); ++bit) {
    if ((mask >> bit & 1U) == 0) continue;
    if (sizes[bit] == 0) return std::nullopt;
    total += sizes[bit];
  }
  return total;
}

/// What the bytes from a start character on are.
struct Frame {
  enum class Kind { incomplete, impossible, found } kind = Kind::impossible;
  VectorNavMessage message{};
};

Frame incomplete() { return {Frame::Kind::incomplete}; }

Frame read_binary(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return incomplete();
  const std::uint8_t groups = bytes[1];
  if (groups == 0 || (groups & ~(kCommonGroup | kImuGroup)) != 0) return {};
  VectorNavMessage message;
  std::size_t at = 2;
  std::size_t size = 0;
  const auto read_mask = [&](std::uint16_t& mask, const std::array<std::uint8_t, 16>& sizes) {
    mask = little_endian<std::uint16_t>(bytes.data() + at);
    at += 2;
    const auto fields = size_of(mask, sizes);
    if (fields) size += *fields;
    return fields.has_value();
  };
  if (bytes.size() < at + 2 * static_cast<std::size_t>(std::popcount(groups))) return incomplete();
  if ((groups & kCommonGroup) != 0 && !read_mask(message.fields.common, kCommonSizes)) return {};
  if ((groups & kImuGroup) != 0 && !read_mask(message.fields.imu, kImuSizes)) return {};
  if (size == 0) return {};
  message.frame_size = at + size + kCrcSize;
  if (bytes.size() < message.frame_size) return incomplete();
  // The CRC over a message with its own CRC, high byte first, is 0.
  if (vectornav_crc(bytes.subspan(1, message.frame_size - 1)) != 0) return {};
  message.data = bytes.subspan(at, size);
  return {Frame::Kind::found, message};
}

/// Whether "text*XX" or "text*XXXX" holds.
bool check_holds(std::string_view text, std::string_view check) {
  if (check.size() == 2) return check == fmt::format("{:02X}", exclusive_or(text));
  return check.size() == 4 && check == fmt::format("{:04X}", vectornav_crc(bytes_of(text)));
}

Frame read_text(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kPrefix = "$VN";
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kLongestLine));
  if (all.substr(0, kPrefix.size()) != kPrefix.substr(0, all.size())) return {};
  const auto end = all.find('\n');
  if (end == std::string_view::npos) return all.size() < kLongestLine ? incomplete() : Frame{};
  std::string_view line = all.substr(1, end - 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  const auto star = line.rfind('*');
  if (star == std::string_view::npos || !check_holds(line.substr(0, star), line.substr(star + 1))) return {};
  VectorNavMessage message;
  message.is_text = true;
  message.text = line.substr(0, star);
  message.frame_size = end + 1;
  return {Frame::Kind::found, message};
}

void take_common(VectorNavPacket& packet, std::uint16_t bit, const std::uint8_t* value) {
  if (bit == vectornav_field::kTimeStartup) packet.time_ns = little_endian<std::uint64_t>(value);
  if (bit == vectornav_field::kCommonRate) packet.rate_rps = read_three_floats(value);
  if (bit == vectornav_field::kCommonAccel) packet.accel_mps2 = read_three_floats(value);
}

void take_imu(VectorNavPacket& packet, std::uint16_t bit, const std::uint8_t* value) {
  if (bit == vectornav_field::kTemp) packet.temp_c = read_float(value);
  if (bit == vectornav_field::kAccel) packet.accel_mps2 = read_three_floats(value);
  if (bit == vectornav_field::kRate) packet.rate_rps = read_three_floats(value);
  if (bit == vectornav_field::kSaturation) packet.saturation = little_endian<std::uint16_t>(value);
}

}  // namespace

std::uint16_t vectornav_crc(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) crc = (crc << 8U & 0xFFFFU) ^ kCrcTable[crc >> 8U ^ byte];
  return static_cast<std::uint16_t>(crc);
}

base::Bytes encode_vectornav(std::string_view text) {
  const std::string line = fmt::format("${}*{:02X}\r\n", text, exclusive_or(text));
  return {line.begin(), line.end()};
}

VectorNavPacket decode_vectornav(const VectorNavMessage& binary) {
  VectorNavPacket packet;
  packet.fields = binary.fields;
  const std::uint8_t* value = binary.data.data();
  for (std::size_t bit = 0; bit < kCommonSizes.size(); ++bit) {
    if ((binary.fields.common >> bit & 1U) == 0) continue;
    take_common(packet, static_cast<std::uint16_t>(1U << bit), value);
    value += kCommonSizes[bit];
  }
  for (std::size_t bit = 0; bit < kImuSizes.size(); ++bit) {
    if ((binary.fields.imu >> bit & 1U) == 0) continue;
    take_imu(packet, static_cast<std::uint16_t>(1U << bit), value);
    value += kImuSizes[bit];
  }
  return packet;
}

std::optional<VectorNavMessage> VectorNavDecoder::next() {
  for (;;) {
    skip_until([](std::uint8_t byte) { return byte == kBinaryStart || byte == kTextStart; });
    if (pending_bytes() == 0) return std::nullopt;
    const auto bytes = pending();
    const Frame frame = bytes[0] == kBinaryStart ? read_binary(bytes) : read_text(bytes);
    if (frame.kind == Frame::Kind::incomplete) return std::nullopt;
    if (frame.kind == Frame::Kind::found) {
      take_frame(frame.message.frame_size);
      return frame.message;
    }
    skip_garbage(1);
  }
}

}  // namespace soak::hal::imu
