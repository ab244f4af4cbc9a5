// SPDX-License-Identifier: Apache-2.0
#include "db/run/sample.h"

#include <array>
#include <cstring>
#include <limits>

namespace soak::db {
namespace {

struct TypeEntry {
  std::string_view name;
  std::size_t size;
};

/// Indexed by SampleType.
constexpr std::array<TypeEntry, 9> kTypes = {
    {{"i8", 1}, {"u8", 1}, {"i16", 2}, {"u16", 2}, {"i32", 4}, {"u32", 4}, {"i64", 8}, {"f32", 4}, {"f64", 8}}};

const TypeEntry& entry_of(SampleType type) { return kTypes.at(static_cast<std::size_t>(type)); }

template <class T>
void convert(const Column& column, std::size_t first, double scale, double offset, std::span<double> values) {
  const std::uint8_t* raw = column.raw.data() + first * sizeof(T);
  for (std::size_t row = 0; row < values.size(); ++row) {
    T number;
    std::memcpy(&number, raw + row * sizeof(T), sizeof(T));
    values[row] = scale * static_cast<double>(number) + offset;
  }
  if (column.present.empty()) return;
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (column.present[first + row] == 0) values[row] = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

std::size_t size_of(SampleType type) { return entry_of(type).size; }

std::string_view name_of(SampleType type) { return entry_of(type).name; }

std::optional<SampleType> sample_type_named(std::string_view name) {
  for (std::size_t i = 0; i < kTypes.size(); ++i) {
    if (kTypes[i].name == name) return static_cast<SampleType>(i);
  }
  return std::nullopt;
}

void put_values(const Column& column, std::size_t first, double scale, double offset, std::span<double> values) {
  constexpr std::array kConvert = {convert<std::int8_t>,   convert<std::uint8_t>, convert<std::int16_t>,
                                   convert<std::uint16_t>, convert<std::int32_t>, convert<std::uint32_t>,
                                   convert<std::int64_t>,  convert<float>,        convert<double>};
  kConvert.at(static_cast<std::size_t>(column.type))(column, first, scale, offset, values);
}

std::vector<double> values_of(const Column& column, double scale, double offset) {
  std::vector<double> values(column.rows());
  put_values(column, 0, scale, offset, values);
  return values;
}

}  // namespace soak::db
