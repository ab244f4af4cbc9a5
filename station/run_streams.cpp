// SPDX-License-Identifier: Apache-2.0
#include "station/run_streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

namespace soak::station {
namespace {

constexpr std::array<std::string_view, 3> kUpChannels = {"up_x", "up_y", "up_z"};

db::Column column_of(const std::vector<double>& values) {
  db::Column column{db::SampleType::f64, base::Bytes(values.size() * sizeof(double)), {}};
  std::memcpy(column.raw.data(), values.data(), column.raw.size());
  return column;
}

constexpr std::string_view kRateChannel = "rate_dps";

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

/// The rates of the positions, no value where the fixture rests; nothing where it rests in all of them.
std::optional<db::Column> rate_column(const std::vector<PlacedPosition>& rows) {
  std::vector<double> rates;
  std::vector<std::uint8_t> present;
  for (const PlacedPosition& row : rows) {
    rates.push_back(row.position->rate_dps.value_or(0.0));
    present.push_back(row.position->rate_dps ? 1 : 0);
  }
  const auto turning = std::count(present.begin(), present.end(), 1);
  if (turning == 0) return std::nullopt;
  db::Column column = column_of(rates);
  if (static_cast<std::size_t>(turning) < rows.size()) column.present = std::move(present);
  return column;
}

base::Status read_rates(const db::RunFileReader& file, std::size_t stream, std::vector<calib::Position>& positions) {
  const auto channel = find_channel(file.streams()[stream].channels, kRateChannel);
  if (!channel) return {};
  const auto column = file.read(stream, *channel);
  if (!column) return base::forward_error(column);
  const std::vector<double> rates = db::values_of(*column, 1.0, 0.0);
  for (std::size_t row = 0; row < positions.size() && row < rates.size(); ++row) {
    if (!std::isnan(rates[row])) positions[row].rate_dps = rates[row];
  }
  return {};
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
  return base::bad_input(fmt::format("the run file holds no samples of unit '{}'", unit), file.info().run_id);
}

base::Status write_positions(db::RunFileWriter& file, std::string_view unit,
                             const std::vector<calib::Position>& positions,
                             const std::vector<db::ChannelInfo>& channels, const std::vector<db::Column>& columns) {
  const std::vector<PlacedPosition> rows = placed(positions, channels, columns);
  if (rows.empty()) return {};
  db::StreamInfo stream{std::string(kPositionsStream), std::string(unit), {}};
  stream.channels.push_back({.name = "t_s", .source_name = "t_s", .unit = "s", .labels = {}});
  db::ChannelInfo label{
      .name = "position", .source_name = "position", .type = db::SampleType::u32, .unit = "label", .labels = {}};
  std::vector<double> t_s;
  std::vector<std::uint32_t> number;
  std::array<std::vector<double>, 3> up;
  for (const PlacedPosition& row : rows) {
    t_s.push_back(row.t_s);
    number.push_back(static_cast<std::uint32_t>(label.labels.size()));
    label.labels.push_back(row.position->label);
    for (std::size_t axis = 0; axis < 3; ++axis) up[axis].push_back(row.position->up[axis]);
  }
  stream.channels.push_back(std::move(label));
  db::Column labels{db::SampleType::u32, base::Bytes(number.size() * sizeof(std::uint32_t)), {}};
  std::memcpy(labels.raw.data(), number.data(), labels.raw.size());
  std::vector<db::Column> table = {column_of(t_s), std::move(labels)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    stream.channels.push_back({.name = std::string(kUpChannels[axis]),
                               .source_name = std::string(kUpChannels[axis]),
                               .unit = "",
                               .labels = {}});
    table.push_back(column_of(up[axis]));
  }
  if (auto rates = rate_column(rows)) {
    stream.channels.push_back(
        {.name = std::string(kRateChannel), .source_name = std::string(kRateChannel), .unit = "dps", .labels = {}});
    table.push_back(*std::move(rates));
  }
  const auto index = file.add_stream(stream);
  if (!index) return base::forward_error(index);
  return file.append(*index, table);
}

base::Result<std::vector<calib::Position>> read_positions(const db::RunFileReader& file, std::string_view unit) {
  std::vector<calib::Position> positions;
  const auto stream = find_stream(file, kPositionsStream, unit);
  if (!stream) return positions;
  const auto& channels = file.streams()[*stream].channels;
  const auto label_channel = find_channel(channels, "position");
  if (!label_channel) return base::corrupt("the table of positions has no labels", file.info().run_id);
  const auto labels = file.read(*stream, *label_channel);
  if (!labels) return base::forward_error(labels);
  for (const double number : db::values_of(*labels, 1.0, 0.0)) {
    if (!(number >= 0.0 && number < static_cast<double>(channels[*label_channel].labels.size()))) {
      return base::corrupt("the table of positions names a label that is not there", file.info().run_id);
    }
    positions.push_back({.label = channels[*label_channel].labels[static_cast<std::size_t>(number)],
                         .up = {},
                         .azimuth_deg = {},
                         .rate_dps = {}});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto channel = find_channel(channels, kUpChannels[axis]);
    if (!channel) return base::corrupt("the table of positions lacks an up vector", file.info().run_id);
    const auto column = file.read(*stream, *channel);
    if (!column) return base::forward_error(column);
    const std::vector<double> values = db::values_of(*column, 1.0, 0.0);
    for (std::size_t row = 0; row < positions.size() && row < values.size(); ++row)
      positions[row].up[axis] = values[row];
  }
  if (const auto read = read_rates(file, *stream, positions); !read) return base::forward_error(read);
  return positions;
}

}  // namespace soak::station
