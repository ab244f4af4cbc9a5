// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/bytes.h"
#include "hal/imu/detail/frame_decoder.h"

/// What an Xsens MTi sends: frames of the Xbus protocol, and the packets of measurements in some of them.
namespace soak::hal::imu {

/// Message identifiers of the Xbus protocol; the answer to a request has the next number.
enum class Mid : std::uint8_t {
  request_device_id = 0x00,
  request_product_code = 0x1C,
  request_firmware = 0x12,
  go_to_measurement = 0x10,
  go_to_config = 0x30,
  mt_data2 = 0x36,
  wake_up = 0x3E,
  wake_up_ack = 0x3F,
  error = 0x42,
  set_output_configuration = 0xC0,
};

[[nodiscard]] constexpr Mid answer_to(Mid request) { return static_cast<Mid>(static_cast<std::uint8_t>(request) + 1); }

/// Most data bytes that a message may have.
inline constexpr std::size_t kMaxXbusData = 8192 - 7;

/// A message whose frame was valid; the data belong to the decoder.
struct XbusMessage {
  std::uint8_t bus = 0;
  Mid id{};
  std::span<const std::uint8_t> data;
  std::size_t frame_size = 0;  ///< with preamble, header and checksum
};

/// Frame FA, bus FF, MID, length, data, checksum: the sum of all bytes after FA is 0 modulo 256. At most kMaxXbusData
/// bytes of data; from 255 on the length takes the extended form FF, high byte, low byte.
[[nodiscard]] base::Bytes encode_xbus(Mid id, std::span<const std::uint8_t> data = {});

/// Finds the messages in a stream of bytes that may be split and damaged anywhere. Behind a frame that does not hold it
/// goes on with the byte after that frame's FA, so that a true frame which begins inside a false one is found. The
/// checksum is a sum: every single wrong byte shows; two that compensate each other, and bytes that changed places, do
/// not. Keeps at most one incomplete frame besides what the last append() brought.
class XbusDecoder : public FrameDecoder {
 public:
  /// The next message; its data are valid until the next call of any kind.
  [[nodiscard]] std::optional<XbusMessage> next();
};

/// Data identifiers of MTData2 without the lowest four bits, which tell the number format and the frame of reference.
namespace data_id {
inline constexpr std::uint16_t kTemperature = 0x0810;
inline constexpr std::uint16_t kPacketCounter = 0x1020;
inline constexpr std::uint16_t kSampleTimeFine = 0x1060;
inline constexpr std::uint16_t kAcceleration = 0x4020;
inline constexpr std::uint16_t kRateOfTurn = 0x8020;
inline constexpr std::uint16_t kStatusWord = 0xE020;
}  // namespace data_id

/// Ticks of SampleTimeFine per second.
inline constexpr double kSampleTimeFine_hz = 10'000.0;

/// What a packet carries of the quantities that the station uses.
struct MtData2 {
  std::optional<std::uint16_t> packet_counter;
  std::optional<std::uint32_t> sample_time_fine;  ///< ticks of 0.1 ms
  std::optional<std::array<float, 3>> accel_mps2;
  std::optional<std::array<float, 3>> rate_rps;
  std::optional<float> temp_c;
  std::optional<std::uint32_t> status;
};

/// Decodes the data of an MTData2 message: a sequence of identifier (16 bits), size (8 bits), value, all big-endian.
/// Numbers may come as float32, fixed point 12.20, fixed point 16.32 (fraction first) or float64; the wider ones are
/// rounded to float32. Other identifiers are skipped. Nothing if an element goes past the end or has a size that its
/// identifier does not allow.
[[nodiscard]] std::optional<MtData2> decode_mt_data2(std::span<const std::uint8_t> data);

/// True if the status word says that an accelerometer or gyro was at its rail: bits 8 to 13, or bit 19, which stands
/// for all sensors, where no magnetometer (bits 14 to 16) explains it. A motor of the chamber may saturate those for
/// hours.
[[nodiscard]] constexpr bool says_clipped(std::uint32_t status) {
  constexpr std::uint32_t kAccelOrGyro = 0x0000'3F00U;
  constexpr std::uint32_t kMagnetometer = 0x0001'C000U;
  constexpr std::uint32_t kAny = 0x0008'0000U;
  return (status & kAccelOrGyro) != 0 || (status & (kAny | kMagnetometer)) == kAny;
}

}  // namespace soak::hal::imu
