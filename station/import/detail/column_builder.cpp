// SPDX-License-Identifier: Apache-2.0
#include "station/import/detail/csv_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/text.h"
#include "station/io/csv_scanner.h"

namespace soak::station {
namespace {

using db::SampleType;

struct WholeRange {
  SampleType type;
  std::int64_t low;
  std::int64_t high;
};

template <class T>
constexpr WholeRange range_of(SampleType type) {
  return {type, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
}

// The signed types from narrow to wide come first: a column without a given type takes the first that fits.
constexpr std::array<WholeRange, 7> kWholeRanges = {
    range_of<std::int8_t>(SampleType::i8),    range_of<std::int16_t>(SampleType::i16),
    range_of<std::int32_t>(SampleType::i32),  range_of<std::int64_t>(SampleType::i64),
    range_of<std::uint8_t>(SampleType::u8),   range_of<std::uint16_t>(SampleType::u16),
    range_of<std::uint32_t>(SampleType::u32),
};

bool is_real_type(SampleType type) { return type == SampleType::f32 || type == SampleType::f64; }

const WholeRange& whole_range(SampleType type) {
  return *std::find_if(kWholeRanges.begin(), kWholeRanges.end(), [&](const auto& range) { return range.type == type; });
}

bool is_nan_or_inf(std::string_view cell) {
  std::string lower;
  for (const char c : cell.substr(cell.starts_with('-') || cell.starts_with('+') ? 1 : 0)) {
    lower += static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
  }
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

/// A whole number however it is spelt, "-2052.0" and "1e3" too, as programs that know only floating point write counts.
/// Nothing for what lies between whole numbers, or beyond those that a float64 tells apart.
std::optional<std::int64_t> whole_however_spelt(std::string_view cell) {
  if (const auto whole = base::parse_int(cell)) return whole;
  constexpr double kLargestExact = 9007199254740992.0;  // 2⁵³
  const auto real = base::parse_double(cell);
  if (!real || std::abs(*real) > kLargestExact || std::trunc(*real) != *real) return std::nullopt;
  return static_cast<std::int64_t>(*real);
}

/// Little-endian bytes of `values`, each cast to T.
template <class T, class Source>
base::Bytes encoded(const std::vector<Source>& values) {
  base::Bytes bytes(values.size() * sizeof(T));
  std::uint8_t* out = bytes.data();
  for (const Source value : values) {
    const T number = static_cast<T>(value);
    std::memcpy(out, &number, sizeof(T));
    out += sizeof(T);
  }
  return bytes;
}

base::Bytes encoded_as(SampleType type, const std::vector<std::int64_t>& wholes, const std::vector<double>& reals) {
  switch (type) {
    case SampleType::i8:
      return encoded<std::int8_t>(wholes);
    case SampleType::u8:
      return encoded<std::uint8_t>(wholes);
    case SampleType::i16:
      return encoded<std::int16_t>(wholes);
    case SampleType::u16:
      return encoded<std::uint16_t>(wholes);
    case SampleType::i32:
      return encoded<std::int32_t>(wholes);
    case SampleType::u32:
      return encoded<std::uint32_t>(wholes);
    case SampleType::i64:
      return encoded<std::int64_t>(wholes);
    case SampleType::f32:
      return encoded<float>(reals);
    case SampleType::f64:
      return encoded<double>(reals);
  }
  return {};
}

}  // namespace

ColumnBuilder::ColumnBuilder(const ColumnPlan& plan)
    : plan_(&plan),
      decided_(plan.is_label || plan.role != ColumnRole::auxiliary || plan.type),
      is_label_(plan.is_label),
      is_real_(plan.type && is_real_type(*plan.type)) {
  for (const std::string& label : plan.channel.labels) {
    label_numbers_.emplace(label, static_cast<std::int64_t>(labels_.size()));
    labels_.push_back(label);
  }
}

std::optional<CellProblem> ColumnBuilder::read(std::string_view cell) {
  pending_ = Pending{};
  if (trimmed(cell).empty()) return std::nullopt;
  pending_.present = true;
  pending_.is_label = decided_ ? is_label_ : !reads_as_number(trimmed(cell));
  return pending_.is_label ? read_label(cell) : read_number(trimmed(cell));
}

bool ColumnBuilder::reads_as_number(std::string_view cell) {
  return base::parse_double(cell).has_value() || is_nan_or_inf(cell);
}

std::optional<CellProblem> ColumnBuilder::read_number(std::string_view cell) {
  const bool whole_type = plan_->type && !is_real_type(*plan_->type);
  if (!is_real_) {
    const auto whole = whole_type ? whole_however_spelt(cell) : base::parse_int(cell);
    // "-0" is left to floating point: a whole number would lose the sign.
    if (whole && (*whole != 0 || whole_type || !cell.starts_with('-'))) {
      const bool fits =
          !whole_type || (*whole >= whole_range(*plan_->type).low && *whole <= whole_range(*plan_->type).high);
      if (!fits) {
        const WholeRange& range = whole_range(*plan_->type);
        return CellProblem{
            fmt::format("{} does not fit type {} ({} to {})", cell, db::name_of(range.type), range.low, range.high)};
      }
      pending_.is_whole = true;
      pending_.whole = *whole;
      return std::nullopt;
    }
  }
  if (whole_type) {
    return CellProblem{fmt::format("'{}' is not a whole number, as type {} needs", cell, db::name_of(*plan_->type))};
  }
  std::optional<double> real;
  if (plan_->type == SampleType::f32) {
    if (const auto single = base::parse_float(cell)) real = *single;
  } else {
    real = base::parse_double(cell);
  }
  if (!real) {
    return CellProblem{
        is_nan_or_inf(cell)
            ? fmt::format("'{}' is not a measurement: give a finite number, or an empty cell for no new value", cell)
            : fmt::format("'{}' is not a number: give a decimal number with a dot, or an empty cell for no new value",
                          cell)};
  }
  pending_.real = *real;
  return std::nullopt;
}

std::optional<CellProblem> ColumnBuilder::read_label(std::string_view cell) {
  if (plan_->role != ColumnRole::auxiliary) cell = trimmed(cell);
  const auto known = label_numbers_.find(cell);
  if (known != label_numbers_.end()) {
    pending_.whole = known->second;
    return std::nullopt;
  }
  if (plan_->refuse_label) {
    if (auto reason = plan_->refuse_label(cell)) return CellProblem{*std::move(reason), false};
  }
  pending_.whole = static_cast<std::int64_t>(labels_.size());
  if (plan_->type && pending_.whole > whole_range(*plan_->type).high) {
    return CellProblem{fmt::format("label '{}' is one too many for type {}", cell, db::name_of(*plan_->type)), false};
  }
  pending_.label = cell;
  return std::nullopt;
}

void ColumnBuilder::commit() {
  present_.push_back(pending_.present ? 1 : 0);
  if (pending_.present) {
    ++values_;
    decided_ = true;
    is_label_ = pending_.is_label;
  }
  if (!pending_.label.empty()) {
    label_numbers_.emplace(std::string(pending_.label), pending_.whole);
    labels_.emplace_back(pending_.label);
  }
  const bool is_whole = !pending_.present || pending_.is_label || pending_.is_whole;
  commit_number(is_whole, pending_.whole, pending_.real);
}

void ColumnBuilder::commit_number(bool is_whole, std::int64_t whole, double real) {
  if (!is_whole && !is_real_) {
    reals_.assign(wholes_.begin(), wholes_.end());
    wholes_ = {};
    is_real_ = true;
  }
  if (is_real_) {
    reals_.push_back(is_whole ? static_cast<double>(whole) : real);
  } else {
    wholes_.push_back(whole);
  }
}

double ColumnBuilder::pending_value() const {
  if (!pending_.present) return std::numeric_limits<double>::quiet_NaN();
  const double number = pending_.is_whole ? static_cast<double>(pending_.whole) : pending_.real;
  return plan_->channel.scale * number + plan_->channel.offset;
}

SampleType ColumnBuilder::final_type() const {
  if (plan_->type) return *plan_->type;
  if (is_real_ || (values_ == 0 && !is_label_)) return SampleType::f64;
  if (is_label_)
    return labels_.size() <= 256 ? SampleType::u8 : labels_.size() <= 65536 ? SampleType::u16 : SampleType::u32;
  const auto [low, high] = std::minmax_element(wholes_.begin(), wholes_.end());
  for (const WholeRange& range : kWholeRanges) {
    if (*low >= range.low && *high <= range.high) return range.type;
  }
  return SampleType::i64;
}

std::pair<db::ChannelInfo, db::Column> ColumnBuilder::finish() {
  db::ChannelInfo channel = plan_->channel;
  channel.type = final_type();
  if (is_label_) {
    channel.unit = "label";
    channel.labels = std::move(labels_);
  }
  if (is_real_type(channel.type) && !is_real_) reals_.assign(wholes_.begin(), wholes_.end());
  db::Column column{channel.type, encoded_as(channel.type, wholes_, reals_), {}};
  if (values_ < present_.size()) column.present = std::move(present_);
  return {std::move(channel), std::move(column)};
}

}  // namespace soak::station
