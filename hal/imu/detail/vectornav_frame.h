// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "hal/imu/detail/frame_decoder.h"

namespace soak::hal::imu {

/// CRC-16 of VectorNav: polynomial 1021, begins with 0, nothing reflected (XMODEM; 31C3 over "123456789").
[[nodiscard]] std::uint16_t vectornav_crc(std::span<const std::uint8_t> bytes);

/// Names the fields of a binary output: group byte and the masks of groups 1 (common) and 3 (IMU); 0 = group absent.
struct VectorNavFields {
  std::uint16_t common = 0;
  std::uint16_t imu = 0;

  bool operator==(const VectorNavFields&) const = default;
};

/// Bits of the masks.
namespace vectornav_field {
inline constexpr std::uint16_t kTimeStartup = 1U << 0U;  ///< common: 8 bytes, ns
inline constexpr std::uint16_t kCommonRate = 1U << 5U;   ///< common: 3 × float, rad/s
inline constexpr std::uint16_t kCommonAccel = 1U << 8U;  ///< common: 3 × float, m/s²
inline constexpr std::uint16_t kTemp = 1U << 4U;         ///< IMU: float, °C
inline constexpr std::uint16_t kAccel = 1U << 9U;        ///< IMU: 3 × float, m/s²
inline constexpr std::uint16_t kRate = 1U << 10U;        ///< IMU: 3 × float, rad/s
inline constexpr std::uint16_t kSaturation = 1U << 11U;  ///< IMU: 2 bytes of flags
}  // namespace vectornav_field

/// What a message carries of the quantities that the station uses.
struct VectorNavPacket {
  VectorNavFields fields;
  std::optional<std::uint64_t> time_ns;  ///< since startup
  std::optional<std::array<float, 3>> accel_mps2;
  std::optional<std::array<float, 3>> rate_rps;
  std::optional<float> temp_c;
  std::optional<std::uint16_t> saturation;
};

/// A message whose check held; bytes and text belong to the decoder.
struct VectorNavMessage {
  bool is_text = false;
  std::string_view text;               ///< of a line "$...*XX", between $ and *
  VectorNavFields fields;              ///< of a binary output
  std::span<const std::uint8_t> data;  ///< its values, in the order of the bits, group 1 before group 3
  std::size_t frame_size = 0;
};

[[nodiscard]] VectorNavPacket decode_vectornav(const VectorNavMessage& binary);

/// "$`text`*XX" and line end, with the exclusive or of the text's bytes as its check.
[[nodiscard]] base::Bytes encode_vectornav(std::string_view text);

/// Finds binary outputs (FA, groups, masks, values, CRC-16) and lines ("$VN...*" with 8-bit or CRC-16 check) in a
/// stream that may be split and damaged anywhere. Only groups 1 and 3 are known: outputs with others count as garbage.
/// Behind a frame that does not hold it goes on with the byte after its first, so that a true frame which begins inside
/// a false one is found. Keeps at most one incomplete frame (some 400 bytes) besides what the last append() brought.
class VectorNavDecoder : public FrameDecoder {
 public:
  /// The next message; its contents are valid until the next call of any kind.
  [[nodiscard]] std::optional<VectorNavMessage> next();
};

}  // namespace soak::hal::imu
