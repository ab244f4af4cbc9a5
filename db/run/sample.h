// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"

namespace soak::db {

/// Binary form of a source's numbers. A run file keeps the source's own numbers in their own type.
enum class SampleType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, f32, f64 };

[[nodiscard]] std::size_t size_of(SampleType type);
[[nodiscard]] std::string_view name_of(SampleType type);
[[nodiscard]] std::optional<SampleType> sample_type_named(std::string_view name);

/// What a channel holds and what its numbers mean: value in `unit` = scale · number + offset.
struct ChannelInfo {
  std::string name;         ///< canonical name: t_s, temp_c, gyro_x, accel_z, position, phase, chamber_c...
  std::string source_name;  ///< the source's own name for it (CSV header cell, protocol field)
  SampleType type = SampleType::f64;
  std::string unit;  ///< unit after scaling, as in CSV suffixes: "s", "c", "k", "dps", "rps", "mps2", "g", "label", ""
  double scale = 1.0;
  double offset = 0.0;
  std::vector<std::string> labels;  ///< only for unit "label": the text that each number stands for

  bool operator==(const ChannelInfo&) const = default;
};

/// Numbers of one channel, row by row, in the source's type. Bit-exact: nothing is converted.
struct Column {
  SampleType type = SampleType::f64;
  base::Bytes raw;                    ///< rows · size_of(type) bytes, little-endian; absent rows hold zero bytes
  std::vector<std::uint8_t> present;  ///< one byte per row, 1 = new value; empty = all present

  [[nodiscard]] std::size_t rows() const { return raw.size() / size_of(type); }
  bool operator==(const Column&) const = default;
};

/// The column's numbers as doubles, scale and offset applied; NaN where no value is present.
[[nodiscard]] std::vector<double> values_of(const Column& column, double scale, double offset);
/// The same of rows first ... first + values.size() - 1, in the caller's memory.
void put_values(const Column& column, std::size_t first, double scale, double offset, std::span<double> values);

}  // namespace soak::db
