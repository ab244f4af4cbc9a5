// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_columns.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "calib/vocabulary/position.h"

namespace soak::station {
namespace {

using db::SampleType;

template <class T>
constexpr SampleType kTypeOf = SampleType::f64;
template <>
constexpr SampleType kTypeOf<float> = SampleType::f32;
template <>
constexpr SampleType kTypeOf<std::uint32_t> = SampleType::u32;
template <>
constexpr SampleType kTypeOf<std::int16_t> = SampleType::i16;
template <>
constexpr SampleType kTypeOf<std::uint8_t> = SampleType::u8;

/// The column of `value_of(sample, row)`, which gives a T or an optional T, over some samples.
template <class T, class ValueOf>
db::Column column_of(std::span<const hal::ImuSample> samples, ValueOf value_of) {
  db::Column column{kTypeOf<T>, base::Bytes(samples.size() * sizeof(T)), std::vector<std::uint8_t>(samples.size(), 1)};
  for (std::size_t row = 0; row < samples.size(); ++row) {
    const std::optional<T> value = value_of(samples[row], row);
    column.present[row] = value ? 1 : 0;
    if (value) std::memcpy(column.raw.data() + row * sizeof(T), &*value, sizeof(T));
  }
  return column;
}

/// The same for a value that all rows share.
template <class T>
db::Column constant_column(std::span<const hal::ImuSample> samples, std::optional<T> value) {
  return column_of<T>(samples, [&](const auto&, std::size_t) { return value; });
}

db::Column one_value(std::optional<double> value) {
  db::Column column{SampleType::f64, base::Bytes(sizeof(double)), {static_cast<std::uint8_t>(value ? 1 : 0)}};
  if (value) std::memcpy(column.raw.data(), &*value, sizeof(double));
  return column;
}

db::ChannelInfo channel(std::string_view name, SampleType type, std::string_view unit, std::string_view header = {}) {
  db::ChannelInfo info;
  info.name = name;
  info.source_name = header.empty() ? name : header;
  info.type = type;
  info.unit = unit;
  return info;
}

db::ChannelInfo label_channel(std::string_view name, std::vector<std::string> labels) {
  db::ChannelInfo info = channel(name, SampleType::u8, "label");
  info.labels = std::move(labels);
  return info;
}

/// Number of a position's label; nothing for "moving".
std::optional<std::uint8_t> position_number(std::string_view label) {
  const auto& labels = calib::kSixPositionLabels;
  const auto found = std::find(labels.begin(), labels.end(), label);
  if (found == labels.end()) return std::nullopt;
  return static_cast<std::uint8_t>(found - labels.begin());
}

std::optional<std::uint8_t> phase_number(calib::Phase phase) {
  return static_cast<std::uint8_t>(phase == calib::Phase::soak ? 0 : 1);
}

std::optional<std::uint8_t> sweep_number(calib::Sweep sweep) {
  if (sweep == calib::Sweep::unknown) return std::nullopt;
  return static_cast<std::uint8_t>(sweep == calib::Sweep::up ? 0 : 1);
}

}  // namespace

std::vector<db::ChannelInfo> imu_channels(bool with_supply, bool with_rates) {
  std::vector<db::ChannelInfo> channels = {
      channel("t_s", SampleType::f64, "s"),
      label_channel("phase", {"soak", "ramp"}),
      label_channel("sweep", {"up", "down"}),
      channel("plateau_c", SampleType::f64, "c"),
      label_channel("position", {calib::kSixPositionLabels.begin(), calib::kSixPositionLabels.end()}),
      channel(kVisitChannel, SampleType::i16, ""),
      channel("chamber_c", SampleType::f64, "c"),
      channel("temp_c", SampleType::f32, "c"),
      channel("gyro_x", SampleType::f32, "rps", "gx_rps"),
      channel("gyro_y", SampleType::f32, "rps", "gy_rps"),
      channel("gyro_z", SampleType::f32, "rps", "gz_rps"),
      channel("accel_x", SampleType::f32, "mps2", "ax_mps2"),
      channel("accel_y", SampleType::f32, "mps2", "ay_mps2"),
      channel("accel_z", SampleType::f32, "mps2", "az_mps2"),
      channel("packet", SampleType::u32, ""),
      channel("status", SampleType::u32, "")};
  if (with_supply) {
    channels.push_back(channel("supply_v", SampleType::f64, "v"));
    channels.push_back(channel("supply_a", SampleType::f64, "a"));
  }
  if (with_rates) channels.push_back(channel("rate_dps", SampleType::f64, "dps"));
  return channels;
}

std::vector<db::ChannelInfo> chamber_channels() {
  return {channel("t_s", SampleType::f64, "s"),           channel("chamber_c", SampleType::f64, "c"),
          channel("set_point_c", SampleType::f64, "c"),   channel("working_set_point_c", SampleType::f64, "c"),
          channel("output_percent", SampleType::f64, ""), channel("chamber_rh", SampleType::f64, "")};
}

std::vector<db::Column> imu_columns(std::span<const hal::ImuSample> samples, const RowLabels& labels,
                                    std::optional<int> visit, const SlowReadings& fresh, bool with_rates) {
  const auto in_first_row = [&](const std::optional<double>& value) {
    return column_of<double>(samples, [&](const auto&, std::size_t row) { return row == 0 ? value : std::nullopt; });
  };
  std::vector<db::Column> columns;
  columns.push_back(column_of<double>(samples, [](const auto& s, std::size_t) { return s.t_s; }));
  columns.push_back(constant_column(samples, phase_number(labels.phase)));
  columns.push_back(constant_column(samples, sweep_number(labels.sweep)));
  columns.push_back(constant_column(samples, labels.plateau_c));
  columns.push_back(constant_column(samples, position_number(labels.position)));
  const auto visit_number = visit ? std::optional(static_cast<std::int16_t>(*visit)) : std::nullopt;
  columns.push_back(constant_column(samples, visit_number));
  columns.push_back(in_first_row(fresh.chamber_c));
  columns.push_back(column_of<float>(samples, [](const auto& s, std::size_t) { return s.temp_c; }));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.push_back(column_of<float>(samples, [axis](const auto& s, std::size_t) { return s.rate_rps[axis]; }));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.push_back(column_of<float>(samples, [axis](const auto& s, std::size_t) { return s.accel_mps2[axis]; }));
  }
  columns.push_back(column_of<std::uint32_t>(samples, [](const auto& s, std::size_t) { return s.packet; }));
  columns.push_back(column_of<std::uint32_t>(samples, [](const auto& s, std::size_t) { return s.status; }));
  if (fresh.with_supply) {
    columns.push_back(in_first_row(fresh.supply_v));
    columns.push_back(in_first_row(fresh.supply_a));
  }
  const bool placed = !labels.position.empty();
  if (with_rates) columns.push_back(constant_column(samples, placed ? std::optional(labels.rate_dps) : std::nullopt));
  return columns;
}

std::vector<db::Column> chamber_columns(double t_s, const hal::ChamberReading& reading) {
  return {one_value(t_s),
          one_value(reading.air_c),
          one_value(reading.set_point_c),
          one_value(reading.working_set_point_c),
          one_value(reading.output_percent),
          one_value(reading.air_rh_percent)};
}

}  // namespace soak::station
