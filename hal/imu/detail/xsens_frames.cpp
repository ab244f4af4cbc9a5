// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xsens_frames.h"

#include <bit>
#include <concepts>
#include <numeric>

namespace soak::hal::imu {

// --- frames

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
struct XbusHeader {
  enum class Kind { incomplete, impossible, found } kind;
  std::size_t header_size = 0;
  std::size_t data_size = 0;

  [[nodiscard]] std::size_t frame_size() const { return header_size + data_size + 1; }
};

XbusHeader read_header(std::span<const std::uint8_t> bytes) {
  using enum XbusHeader::Kind;
  if (bytes.size() < kShortHeader) return {incomplete};
  // Zeros behind an FA are no message: no device has bus 0, and request 0 comes from the host alone.
  if (bytes[1] == 0 && bytes[2] == 0) return {impossible};
  if (bytes[3] != kExtended) return {found, kShortHeader, bytes[3]};
  if (bytes.size() < kLongHeader) return {incomplete};
  const std::size_t size = static_cast<std::size_t>(bytes[4]) << 8U | bytes[5];
  return size > kMaxXbusData ? XbusHeader{impossible} : XbusHeader{found, kLongHeader, size};
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

std::optional<XbusMessage> XbusDecoder::next() {
  for (;;) {
    skip_until([](std::uint8_t byte) { return byte == kPreamble; });
    const auto bytes = pending();
    const XbusHeader header = read_header(bytes);
    if (header.kind == XbusHeader::Kind::incomplete) return std::nullopt;
    if (header.kind == XbusHeader::Kind::found) {
      if (bytes.size() < header.frame_size()) return std::nullopt;
      if (sum_of(bytes.subspan(1, header.frame_size() - 1)) == 0) {
        take_frame(header.frame_size());
        return XbusMessage{bytes[1], static_cast<Mid>(bytes[2]), bytes.subspan(header.header_size, header.data_size),
                           header.frame_size()};
      }
    }
    skip_garbage(1);
  }
}

// --- measurements

namespace {

constexpr std::uint16_t kTypeMask = 0xFFF0;
constexpr std::uint16_t kFormatMask = 0x0003;

struct Element {
  std::uint16_t id;
  std::span<const std::uint8_t> value;
};

float read_float32(const std::uint8_t* bytes) { return std::bit_cast<float>(big_endian<std::uint32_t>(bytes)); }

float read_fixed_12_20(const std::uint8_t* bytes) {
  return static_cast<float>(static_cast<std::int32_t>(big_endian<std::uint32_t>(bytes)) * 0x1p-20);
}

float read_fixed_16_32(const std::uint8_t* bytes) {
  const double fraction = big_endian<std::uint32_t>(bytes) * 0x1p-32;
  return static_cast<float>(static_cast<std::int16_t>(big_endian<std::uint16_t>(bytes + 4)) + fraction);
}

float read_float64(const std::uint8_t* bytes) {
  return static_cast<float>(std::bit_cast<double>(big_endian<std::uint64_t>(bytes)));
}

struct Format {
  std::size_t size;
  float (*read)(const std::uint8_t*);
};

constexpr std::array<Format, 4> kFormats = {
    {{4, read_float32}, {4, read_fixed_12_20}, {6, read_fixed_16_32}, {8, read_float64}}};

template <std::size_t N>
bool read_reals(const Element& element, std::optional<std::array<float, N>>& target) {
  const Format& format = kFormats[element.id & kFormatMask];
  if (element.value.size() != N * format.size) return false;
  target.emplace();
  for (std::size_t i = 0; i < N; ++i) (*target)[i] = format.read(element.value.data() + i * format.size);
  return true;
}

bool read_real(const Element& element, std::optional<float>& target) {
  std::optional<std::array<float, 1>> one;
  if (!read_reals(element, one)) return false;
  target = one->front();
  return true;
}

template <std::unsigned_integral T>
bool read_number(const Element& element, std::optional<T>& target) {
  if (element.value.size() != sizeof(T)) return false;
  target = big_endian<T>(element.value.data());
  return true;
}

/// False if the size does not fit the identifier.
bool read_element(const Element& element, MtData2& packet) {
  switch (element.id & kTypeMask) {
    case data_id::kPacketCounter:
      return read_number(element, packet.packet_counter);
    case data_id::kSampleTimeFine:
      return read_number(element, packet.sample_time_fine);
    case data_id::kAcceleration:
      return read_reals(element, packet.accel_mps2);
    case data_id::kRateOfTurn:
      return read_reals(element, packet.rate_rps);
    case data_id::kTemperature:
      return read_real(element, packet.temp_c);
    case data_id::kStatusWord:
      return read_number(element, packet.status);
    default:
      return true;
  }
}

}  // namespace

std::optional<MtData2> decode_mt_data2(std::span<const std::uint8_t> data) {
  constexpr std::size_t kHead = 3;
  MtData2 packet;
  while (!data.empty()) {
    if (data.size() < kHead) return std::nullopt;
    const std::size_t size = data[2];
    if (data.size() < kHead + size) return std::nullopt;
    if (!read_element({big_endian<std::uint16_t>(data.data()), data.subspan(kHead, size)}, packet)) return std::nullopt;
    data = data.subspan(kHead + size);
  }
  return packet;
}

}  // namespace soak::hal::imu
