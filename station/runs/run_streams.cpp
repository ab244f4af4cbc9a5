// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace soak::station {
namespace {

constexpr std::array<std::string_view, 3> kUpChannels = {"up_x", "up_y", "up_z"};

/// What a position may have besides its direction; the channel is there if any of them has it.
struct OptionalChannel {
  std::string_view name;
  std::string_view unit;
  std::optional<double> calib::Position::* member;
};
constexpr std::array<OptionalChannel, 2> kOptionalChannels = {
    {{"rate_dps", "dps", &calib::Position::rate_dps}, {"azimuth_deg", "deg", &calib::Position::azimuth_deg}}};

bool occurs(const OptionalChannel& optional, std::span<const calib::Position> positions) {
  return std::any_of(positions.begin(), positions.end(),
                     [&](const calib::Position& position) { return (position.*optional.member).has_value(); });
}

/// A column of one row; zero bytes where there is no value.
db::Column one_row(std::optional<double> value) {
  db::Column column{db::SampleType::f64, base::Bytes(sizeof(double)), {static_cast<std::uint8_t>(value ? 1 : 0)}};
  if (value) std::memcpy(column.raw.data(), &*value, sizeof(double));
  return column;
}

struct PlacedPosition {
  double t_s;
  const calib::Position* position;
};

/// The positions with the time of their first row, in the order of time.
std::vector<PlacedPosition> placed(const std::vector<calib::Position>& positions,
                                   const std::vector<db::ChannelInfo>& channels,
                                   const std::vector<db::Column>& columns) {
  std::vector<PlacedPosition> result;
  const auto label_channel = find_channel(channels, "position");
  if (!label_channel) return result;
  const auto& labels = channels[*label_channel].labels;
  const std::vector<double> number = db::values_of(columns[*label_channel], 1.0, 0.0);
  const std::vector<double> t_s = db::values_of(columns.front(), channels.front().scale, channels.front().offset);
  for (const calib::Position& position : positions) {
    const auto index = static_cast<double>(std::find(labels.begin(), labels.end(), position.label) - labels.begin());
    const auto first = std::find(number.begin(), number.end(), index);
    if (first != number.end()) result.push_back({t_s[static_cast<std::size_t>(first - number.begin())], &position});
  }
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  return result;
}

base::Status read_optional(const db::RunFileReader& file, std::size_t stream, const OptionalChannel& optional,
                           std::vector<calib::Position>& positions) {
  const auto channel = find_channel(file.streams()[stream].channels, optional.name);
  if (!channel) return {};
  const auto column = file.read(stream, *channel);
  if (!column) return base::forward_error(column);
  const std::vector<double> values = db::values_of(*column, 1.0, 0.0);
  for (std::size_t row = 0; row < positions.size() && row < values.size(); ++row) {
    if (!std::isnan(values[row])) positions[row].*optional.member = values[row];
  }
  return {};
}

db::ChannelInfo real_channel(std::string_view name, std::string_view unit) {
  return {.name = std::string(name), .source_name = std::string(name), .unit = std::string(unit), .labels = {}};
}

}  // namespace

std::optional<std::size_t> find_stream(const db::RunFileReader& file, std::string_view name, std::string_view unit) {
  const auto& streams = file.streams();
  for (std::size_t i = 0; i < streams.size(); ++i) {
    if (streams[i].name == name && streams[i].unit == unit) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> find_channel(const std::vector<db::ChannelInfo>& channels, std::string_view name) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return i;
  }
  return std::nullopt;
}

base::Result<std::size_t> imu_stream(const db::RunFileReader& file, std::string_view unit) {
  if (const auto stream = find_stream(file, kImuStream, unit)) return *stream;
  return base::bad_input(fmt::format("the run file has no samples of unit '{}'", unit), file.info().run_id);
}

base::Result<std::size_t> add_position_stream(db::RunFileWriter& file, std::string_view unit,
                                              std::span<const calib::Position> positions) {
  db::StreamInfo stream{std::string(kPositionsStream), std::string(unit), {}};
  stream.channels.push_back(real_channel("t_s", "s"));
  db::ChannelInfo label{
      .name = "position", .source_name = "position", .type = db::SampleType::u32, .unit = "label", .labels = {}};
  for (const calib::Position& position : positions) label.labels.push_back(position.label);
  stream.channels.push_back(std::move(label));
  for (const std::string_view name : kUpChannels) stream.channels.push_back(real_channel(name, ""));
  for (const OptionalChannel& optional : kOptionalChannels) {
    if (occurs(optional, positions)) stream.channels.push_back(real_channel(optional.name, optional.unit));
  }
  return file.add_stream(stream);
}

base::Status append_position(db::RunFileWriter& file, std::size_t stream, std::span<const calib::Position> positions,
                             std::size_t index, double t_s) {
  const calib::Position& position = positions[index];
  const auto number = static_cast<std::uint32_t>(index);
  db::Column label{db::SampleType::u32, base::Bytes(sizeof(number)), {}};
  std::memcpy(label.raw.data(), &number, sizeof(number));
  std::vector<db::Column> row = {one_row(t_s), std::move(label)};
  for (const double component : position.up) row.push_back(one_row(component));
  for (const OptionalChannel& optional : kOptionalChannels) {
    if (occurs(optional, positions)) row.push_back(one_row(position.*optional.member));
  }
  return file.append(stream, row);
}

base::Status write_positions(db::RunFileWriter& file, std::string_view unit,
                             const std::vector<calib::Position>& positions,
                             const std::vector<db::ChannelInfo>& channels, const std::vector<db::Column>& columns) {
  const std::vector<PlacedPosition> rows = placed(positions, channels, columns);
  if (rows.empty()) return {};
  std::vector<calib::Position> in_order;
  for (const PlacedPosition& row : rows) in_order.push_back(*row.position);
  const auto stream = add_position_stream(file, unit, in_order);
  if (!stream) return base::forward_error(stream);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (auto status = append_position(file, *stream, in_order, i, rows[i].t_s); !status) return status;
  }
  return {};
}

base::Result<std::vector<calib::Position>> read_positions(const db::RunFileReader& file, std::string_view unit) {
  std::vector<calib::Position> positions;
  const auto stream = find_stream(file, kPositionsStream, unit);
  if (!stream) return positions;
  const auto& channels = file.streams()[*stream].channels;
  const auto label_channel = find_channel(channels, "position");
  if (!label_channel)
    return base::corrupt("the table of positions has no labels; restore the run file from a backup",
                         file.info().run_id);
  const auto labels = file.read(*stream, *label_channel);
  if (!labels) return base::forward_error(labels);
  for (const double number : db::values_of(*labels, 1.0, 0.0)) {
    if (!(number >= 0.0 && number < static_cast<double>(channels[*label_channel].labels.size()))) {
      return base::corrupt("the table of positions names a label that is not there; restore the run file from a backup",
                           file.info().run_id);
    }
    positions.push_back({.label = channels[*label_channel].labels[static_cast<std::size_t>(number)],
                         .up = {},
                         .azimuth_deg = {},
                         .rate_dps = {}});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto channel = find_channel(channels, kUpChannels[axis]);
    if (!channel)
      return base::corrupt("the table of positions lacks an up vector; restore the run file from a backup",
                           file.info().run_id);
    const auto column = file.read(*stream, *channel);
    if (!column) return base::forward_error(column);
    const std::vector<double> values = db::values_of(*column, 1.0, 0.0);
    for (std::size_t row = 0; row < positions.size() && row < values.size(); ++row)
      positions[row].up[axis] = values[row];
  }
  for (const OptionalChannel& optional : kOptionalChannels) {
    if (const auto read = read_optional(file, *stream, optional, positions); !read) return base::forward_error(read);
  }
  return positions;
}

base::Result<calib::Position> position_of_label(const std::string& label, const std::vector<calib::Position>& defined,
                                                const std::string& run_id) {
  auto position = calib::position_named(label);
  const auto own = std::find_if(defined.begin(), defined.end(), [&](const auto& p) { return p.label == label; });
  if (own != defined.end()) {
    const std::string canonical = position ? position->label : label;
    position = *own;
    position->label = canonical;
  }
  if (!position) {
    return base::corrupt(fmt::format("the run file does not define its position '{}'; restore it from a backup", label),
                         run_id);
  }
  return *std::move(position);
}

}  // namespace soak::station
