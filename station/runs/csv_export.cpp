// SPDX-License-Identifier: Apache-2.0
#include "station/runs/csv_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <set>
#include <utility>
#include <vector>

#include "base/text.h"
#include "calib/vocabulary/sensor.h"
#include "station/import/channel.h"
#include "station/import/columns_map.h"
#include "station/import/source_recording.h"
#include "station/io/csv_scanner.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

using db::SampleType;

/// The samples of one unit, all of them.
struct Samples {
  std::vector<db::ChannelInfo> channels;
  std::vector<db::Column> columns;
  std::vector<calib::Position> positions;
  std::string label;

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().rows(); }
};

base::Result<Samples> read_samples(const db::RunFileReader& file, std::string_view unit) {
  const auto stream = imu_stream(file, unit);
  if (!stream) return base::forward_error(stream);
  Samples samples;
  samples.label = file.info().label;
  samples.channels = file.streams()[*stream].channels;
  for (std::size_t i = 0; i < samples.channels.size(); ++i) {
    auto column = file.read(*stream, i);
    if (!column) return base::forward_error(column);
    samples.columns.push_back(*std::move(column));
  }
  auto positions = read_positions(file, unit);
  if (!positions) return base::forward_error(positions);
  samples.positions = *std::move(positions);
  return samples;
}

template <class T>
T number_at(const db::Column& column, std::size_t row) {
  T number;
  std::memcpy(&number, column.raw.data() + row * sizeof(T), sizeof(T));
  return number;
}

bool is_present(const db::Column& column, std::size_t row) {
  return column.present.empty() || column.present[row] != 0;
}

/// A whole number of any of the types; reals do not come here.
std::int64_t whole_at(const db::Column& column, std::size_t row) {
  switch (column.type) {
    case SampleType::i8:
      return number_at<std::int8_t>(column, row);
    case SampleType::u8:
      return number_at<std::uint8_t>(column, row);
    case SampleType::i16:
      return number_at<std::int16_t>(column, row);
    case SampleType::u16:
      return number_at<std::uint16_t>(column, row);
    case SampleType::i32:
      return number_at<std::int32_t>(column, row);
    case SampleType::u32:
      return number_at<std::uint32_t>(column, row);
    default:
      return number_at<std::int64_t>(column, row);
  }
}

/// The source's own number in its shortest form; empty where there is none.
std::string native_text(const db::Column& column, std::size_t row) {
  if (!is_present(column, row)) return {};
  if (column.type == SampleType::f32) return base::shortest(number_at<float>(column, row));
  if (column.type == SampleType::f64) return base::shortest(number_at<double>(column, row));
  return std::to_string(whole_at(column, row));
}

std::string label_text(const db::ChannelInfo& channel, const db::Column& column, std::size_t row) {
  if (!is_present(column, row)) return {};
  const auto number = static_cast<std::uint64_t>(whole_at(column, row));
  return number < channel.labels.size() ? csv_cell(channel.labels[number]) : std::string();
}

/// The texts of one column of the output, row by row.
class CellWriter {
 public:
  CellWriter(const db::ChannelInfo& channel, const db::Column& column, bool canonical)
      : channel_(channel), column_(column), convert_(conversion_to_csv(channel.unit)) {
    own_numbers_ = !canonical || (channel.scale == 1.0 && channel.offset == 0.0 && convert_(1.0) == 1.0);
    if (!own_numbers_) values_ = db::values_of(column, channel.scale, channel.offset);
  }

  [[nodiscard]] std::string text(std::size_t row) const {
    if (channel_.unit == "label") return label_text(channel_, column_, row);
    if (own_numbers_) return native_text(column_, row);
    return is_present(column_, row) ? base::shortest(convert_(values_[row])) : std::string();
  }

 private:
  const db::ChannelInfo& channel_;
  const db::Column& column_;
  Conversion convert_;
  bool own_numbers_ = false;
  std::vector<double> values_;
};

/// Header line and rows; `order` lists channels, the run label stands after the first of them.
std::string table_text(const Samples& samples, const std::vector<std::size_t>& order,
                       const std::vector<std::string>& headers, std::string_view run_header, bool canonical) {
  std::vector<CellWriter> writers;
  std::string text;
  for (const std::size_t i : order) {
    if (!writers.empty()) text += ',';
    text += csv_cell(headers[i]);
    if (writers.empty()) text.append(",").append(csv_cell(run_header));
    writers.emplace_back(samples.channels[i], samples.columns[i], canonical);
  }
  text += '\n';
  const std::string label = csv_cell(samples.label);
  for (std::size_t row = 0; row < samples.rows(); ++row) {
    text += writers.front().text(row);
    text.append(",").append(label);
    for (std::size_t i = 1; i < writers.size(); ++i) text.append(",").append(writers[i].text(row));
    text += '\n';
  }
  return text;
}

/// Channels in the order of canonical headers, unknown ones behind them.
std::vector<std::size_t> canonical_order(const std::vector<db::ChannelInfo>& channels) {
  constexpr std::array<std::string_view, 8> kLeading = {"t_s",      "phase",    "sweep",     "plateau_c",
                                                        "position", "rate_dps", "chamber_c", "temp_c"};
  std::vector<std::string_view> names(kLeading.begin(), kLeading.end());
  names.insert(names.end(), calib::kSensorNames.begin(), calib::kSensorNames.end());
  std::vector<std::size_t> order;
  for (const std::string_view name : names) {
    if (const auto channel = find_channel(channels, name)) order.push_back(*channel);
  }
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  }
  return order;
}

/// The sources' own headers; the channel's name where a source has none or another channel has the same.
std::vector<std::string> native_headers(const std::vector<db::ChannelInfo>& channels) {
  std::set<std::string> used;
  std::vector<std::string> headers;
  for (const db::ChannelInfo& channel : channels) {
    std::string header(trimmed(channel.source_name));
    if (header.empty() || header != channel.source_name || used.contains(header)) header = channel.name;
    used.insert(header);
    headers.push_back(std::move(header));
  }
  return headers;
}

/// Our header for a channel in its own unit: "gx_rps", "temp_k", "t_s", or the name of an unknown one.
std::string own_header(const db::ChannelInfo& channel) {
  std::string canonical = canonical_header(channel.name);
  const auto meaning = meaning_of_header(canonical);
  if (!meaning || meaning->role == ColumnRole::auxiliary || meaning->unit == channel.unit) return canonical;
  return canonical.substr(0, canonical.rfind('_') + 1) + channel.unit;
}

ColumnsMap complete_map(const Samples& samples, const std::vector<std::string>& headers,
                        const std::string& run_header) {
  ColumnsMap map;
  map.positions = samples.positions;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    const db::ChannelInfo& channel = samples.channels[i];
    MappedColumn column;
    column.source = headers[i];
    column.as = own_header(channel);
    column.is_label = channel.unit == "label";
    column.type = channel.type;
    column.scale = channel.scale;
    column.offset = channel.offset;
    column.labels = channel.labels;
    map.columns.push_back(std::move(column));
  }
  if (run_header != "run")
    map.columns.push_back({.source = run_header, .as = "run", .meaning = {}, .type = {}, .labels = {}});
  return map;
}

std::vector<calib::Position> sorted_by_label(std::vector<calib::Position> positions) {
  std::sort(positions.begin(), positions.end(), [](const auto& a, const auto& b) { return a.label < b.label; });
  return positions;
}

/// Whether an import of `csv` with `map` gives the same samples under the headers that were written.
bool reads_back(const std::string& csv, const ColumnsMap& map, const Samples& samples,
                const std::vector<std::string>& headers) {
  const auto recording = parse_csv_recording(csv, "export.csv", {.map = map, .skip_bad = false, .progress = {}});
  if (!recording || recording->runs.size() != 1) return false;
  const SourceRun& run = recording->runs.front();
  std::vector<db::ChannelInfo> channels = samples.channels;
  for (std::size_t i = 0; i < channels.size(); ++i) channels[i].source_name = headers[i];
  return run.label == samples.label && run.channels == channels && run.columns == samples.columns &&
         sorted_by_label(run.positions) == sorted_by_label(samples.positions);
}

}  // namespace

base::Result<std::string> canonical_csv(const db::RunFileReader& file, std::string_view unit) {
  const auto samples = read_samples(file, unit);
  if (!samples) return base::forward_error(samples);
  std::vector<std::string> headers;
  for (const db::ChannelInfo& channel : samples->channels) headers.push_back(canonical_header(channel.name));
  return table_text(*samples, canonical_order(samples->channels), headers, "run", true);
}

base::Result<NativeCsv> native_csv(const db::RunFileReader& file, std::string_view unit) {
  const auto samples = read_samples(file, unit);
  if (!samples) return base::forward_error(samples);
  const std::vector<std::string> headers = native_headers(samples->channels);
  std::string run_header = "run";
  while (std::find(headers.begin(), headers.end(), run_header) != headers.end()) run_header += "_label";
  std::vector<std::size_t> order(headers.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;

  NativeCsv native{table_text(*samples, order, headers, run_header, false), {}};
  if (reads_back(native.csv, ColumnsMap{}, *samples, headers)) return native;
  native.columns_map = columns_map_text(complete_map(*samples, headers, run_header));
  const auto map = parse_columns_map(*native.columns_map, "columns map of the export");
  if (map && reads_back(native.csv, *map, *samples, headers)) return native;
  return base::fail(base::ErrorKind::internal,
                    "the samples cannot be written as CSV without loss (numbers that are not finite, or a time that "
                    "does not increase): copy the run file instead",
                    fmt::format("{} ({})", file.info().label, file.info().run_id));
}

}  // namespace soak::station
