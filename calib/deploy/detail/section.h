// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib::file {

/// One section of a calibration file before it is written (docs/blob-format.md §3, §4).
struct Section {
  std::uint16_t type = 0;
  bool critical = true;
  base::Bytes payload;  ///< its length is made a multiple of 4 when the file is put together
};

/// Type of the section of a reference; the runtime, which has no use for it, passes over it.
inline constexpr std::uint16_t kReferenceSection = 0x0002;

/// Longest text that the format carries, in bytes.
inline constexpr std::size_t kMaxText = 255;

/// What a curve describes; the value is its number in the file.
enum class Quantity : std::uint8_t { bias, scale_ppm };

constexpr std::string_view name_of(Quantity quantity) { return quantity == Quantity::bias ? "bias" : "scale_ppm"; }

/// "gyro_x bias": names a curve in messages.
[[nodiscard]] std::string place(Sensor sensor, Quantity quantity);

/// Starts the payload of a section that belongs to one curve.
[[nodiscard]] base::ByteWriter payload_of(Sensor sensor, Quantity quantity);

/// The numbers rounded to float32, one after the other.
void write_floats(base::ByteWriter& out, const std::vector<double>& values);

/// Whether a number is finite and stays so when rounded to float32.
[[nodiscard]] bool fits_float(double value);
[[nodiscard]] bool fit_float(const std::vector<double>& values);

/// `count` float32 numbers from `payload`, which holds them all.
[[nodiscard]] std::vector<double> read_floats(const std::uint8_t* payload, std::size_t count);

/// The bytes of a text, without its length.
void write_text(base::ByteWriter& out, const std::string& text);
[[nodiscard]] std::string text_at(const std::uint8_t* first, std::size_t length);

/// Refuses a text that is longer than the format carries; `what` names it.
[[nodiscard]] base::Status check_text(const std::string& text, const std::string& what);

/// The whole file: header, sections, CRC.
[[nodiscard]] base::Bytes assemble(const std::vector<Section>& sections);

}  // namespace soak::calib::file
