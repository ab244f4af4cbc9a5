// SPDX-License-Identifier: Apache-2.0
#include "db/sample.h"

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
std::vector<double> converted(const Column& column, double scale, double offset) {
  std::vector<double> values(column.rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!column.present.empty() && column.present[row] == 0) {
      values[row] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    T number;
    std::memcpy(&number, column.raw.data() + row * sizeof(T), sizeof(T));
    values[row] = scale * static_cast<double>(number) + offset;
  }
  return values;
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

std::vector<double> values_of(const Column& column, double scale, double offset) {
  switch (column.type) {
    case SampleType::i8:
      return converted<std::int8_t>(column, scale, offset);
    case SampleType::u8:
      return converted<std::uint8_t>(column, scale, offset);
    case SampleType::i16:
      return converted<std::int16_t>(column, scale, offset);
    case SampleType::u16:
      return converted<std::uint16_t>(column, scale, offset);
    case SampleType::i32:
      return converted<std::int32_t>(column, scale, offset);
    case SampleType::u32:
      return converted<std::uint32_t>(column, scale, offset);
    case SampleType::i64:
      return converted<std::int64_t>(column, scale, offset);
    case SampleType::f32:
      return converted<float>(column, scale, offset);
    case SampleType::f64:
      return converted<double>(column, scale, offset);
  }
  return {};
}

}  // namespace soak::db
