// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_series.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "station/io/output.h"
#include "station/runs/run_document.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// A stream of the chamber is on the clock of the unit that was first in the run: beside another unit's samples it
/// would stand in the wrong place.
bool is_shown_with(const db::RunFileReader& file, const db::StreamInfo& stream, const std::string& unit) {
  if (stream.name == kPositionsStream) return false;
  if (!stream.unit.empty()) return stream.unit == unit;
  return std::ranges::all_of(file.streams(), [&](const db::StreamInfo& other) {
    return other.unit.empty() || other.unit == unit || other.name == kPositionsStream;
  });
}

struct TimeRange {
  double first_s = 0.0;
  double last_s = 0.0;
};

/// Times of the first and the last row; nothing where there is no row.
base::Result<std::optional<TimeRange>> times_of(const db::RunFileReader& file, std::size_t stream) {
  const std::uint64_t rows = file.rows(stream);
  if (rows == 0) return std::nullopt;
  const db::ChannelInfo& time = file.streams()[stream].channels.front();
  const auto first = file.read(stream, 0, 0, 1);
  if (!first) return base::forward_error(first);
  const auto last = file.read(stream, 0, rows - 1, 1);
  if (!last) return base::forward_error(last);
  return TimeRange{db::values_of(*first, time.scale, time.offset).front(),
                   db::values_of(*last, time.scale, time.offset).front()};
}

/// A channel with the number of its values; slow channels have fewer than the stream has rows.
base::Result<json> counted_channel(const db::RunFileReader& file, std::size_t stream, std::size_t channel,
                                   const std::optional<TimeRange>& times) {
  json document = stored_channel_json(file.streams()[stream].channels[channel]);
  std::uint64_t values = 0;
  if (times) {
    const auto bins = file.pyramid(stream, channel, times->first_s, times->last_s, 1);
    if (!bins) return base::forward_error(bins);
    for (const db::PyramidBin& bin : *bins) values += bin.count;
  }
  const double seconds = times ? times->last_s - times->first_s : 0.0;
  document["values"] = values;
  document["rate_hz"] = values > 1 && seconds > 0.0 ? json(static_cast<double>(values - 1) / seconds) : json();
  return document;
}

base::Result<json> stream_json(const db::RunFileReader& file, std::size_t stream) {
  const db::StreamInfo& info = file.streams()[stream];
  const auto times = times_of(file, stream);
  if (!times) return base::forward_error(times);
  json channels = json::array();
  for (std::size_t i = 0; i < info.channels.size(); ++i) {
    auto channel = counted_channel(file, stream, i, *times);
    if (!channel) return channel;
    channels.push_back(*std::move(channel));
  }
  return json{{"name", info.name},
              {"rows", file.rows(stream)},
              {"first_s", *times ? json((*times)->first_s) : json()},
              {"last_s", *times ? json((*times)->last_s) : json()},
              {"channels", std::move(channels)}};
}

base::Result<std::vector<std::size_t>> indices_of(const std::vector<db::ChannelInfo>& known,
                                                  const std::vector<std::string>& names) {
  std::vector<std::size_t> indices;
  for (const std::string& name : names) {
    const auto index = find_channel(known, name);
    if (index) {
      indices.push_back(*index);
      continue;
    }
    std::vector<std::string> possible;
    for (const db::ChannelInfo& channel : known) possible.push_back(channel.name);
    return base::bad_input(fmt::format("the stream has no channel '{}'; it has {}", name, fmt::join(possible, ", ")),
                           "channel");
  }
  return indices;
}

json numbers_json(std::span<const double> values) {
  json list = json::array();
  for (const double value : values) list.push_back(number_or_null(value));
  return list;
}

base::Result<json> samples_json(const db::RunFileReader& file, std::size_t stream, std::size_t channel,
                                const db::RowSpan& rows) {
  const db::ChannelInfo& info = file.streams()[stream].channels[channel];
  const auto column = file.read(stream, channel, rows.first, rows.count);
  if (!column) return base::forward_error(column);
  return numbers_json(db::values_of(*column, info.scale, info.offset));
}

base::Result<json> buckets_json(const db::RunFileReader& file, std::size_t stream, std::size_t channel,
                                const TimeRange& times, std::size_t points) {
  const auto bins = file.pyramid(stream, channel, times.first_s, times.last_s, points);
  if (!bins) return base::forward_error(bins);
  json document;
  for (const char* name : {"t_first_s", "t_last_s", "count", "minimum", "mean", "maximum"}) {
    document[name] = json::array();
  }
  for (const db::PyramidBin& bin : *bins) {
    document["t_first_s"].push_back(bin.t_first_s);
    document["t_last_s"].push_back(bin.t_last_s);
    document["count"].push_back(bin.count);
    document["minimum"].push_back(bin.minimum);
    document["mean"].push_back(bin.mean);
    document["maximum"].push_back(bin.maximum);
  }
  return document;
}

base::Result<json> channels_json(const db::RunFileReader& file, const SeriesSpan& span,
                                 const std::vector<std::size_t>& channels, const TimeRange& times,
                                 const std::optional<db::RowSpan>& samples) {
  json list = json::array();
  for (const std::size_t channel : channels) {
    const db::ChannelInfo& info = file.streams()[span.stream].channels[channel];
    auto part = samples ? samples_json(file, span.stream, channel, *samples)
                        : buckets_json(file, span.stream, channel, times, span.points);
    if (!part) return part;
    json document = samples ? json{{"values", *std::move(part)}} : *std::move(part);
    document["name"] = info.name;
    document["unit"] = info.unit;
    list.push_back(std::move(document));
  }
  return list;
}

}  // namespace

base::Result<json> streams_json(const db::RunFileReader& file, const std::string& unit) {
  json list = json::array();
  for (std::size_t i = 0; i < file.streams().size(); ++i) {
    if (!is_shown_with(file, file.streams()[i], unit)) continue;
    auto stream = stream_json(file, i);
    if (!stream) return stream;
    list.push_back(*std::move(stream));
  }
  return list;
}

base::Result<std::size_t> stream_named(const db::RunFileReader& file, const std::string& name,
                                       const std::string& unit) {
  std::vector<std::string> possible;
  for (std::size_t i = 0; i < file.streams().size(); ++i) {
    if (!is_shown_with(file, file.streams()[i], unit)) continue;
    if (file.streams()[i].name == name) return i;
    possible.push_back(file.streams()[i].name);
  }
  return base::bad_input(fmt::format("the run has no stream '{}'; it has {}", name, fmt::join(possible, ", ")),
                         "stream");
}

base::Result<json> series_json(const db::RunFileReader& file, const SeriesSpan& span) {
  const auto channels = indices_of(file.streams()[span.stream].channels, span.channels);
  if (!channels) return base::forward_error(channels);
  const auto all = times_of(file, span.stream);
  if (!all) return base::forward_error(all);
  const TimeRange whole = all->value_or(TimeRange{});
  const TimeRange times{span.from_s.value_or(whole.first_s), span.to_s.value_or(whole.last_s)};
  if (times.first_s > times.last_s) {
    return base::bad_input(fmt::format("the span would end at {} s, before it starts at {} s; the run lasts from {} s "
                                       "to {} s",
                                       times.last_s, times.first_s, whole.first_s, whole.last_s),
                           "to_s");
  }
  const auto rows = file.rows_between(span.stream, times.first_s, times.last_s);
  if (!rows) return base::forward_error(rows);
  const auto samples = rows->count <= span.points ? std::optional(*rows) : std::nullopt;
  auto parts = channels_json(file, span, *channels, times, samples);
  if (!parts) return parts;
  json document = {{"stream", file.streams()[span.stream].name},
                   {"from_s", times.first_s},
                   {"to_s", times.last_s},
                   {"rows", rows->count},
                   {"kind", samples ? "samples" : "buckets"},
                   {"t_s", nullptr},
                   {"channels", *std::move(parts)}};
  if (samples) {
    auto t_s = samples_json(file, span.stream, 0, *samples);
    if (!t_s) return t_s;
    document["t_s"] = *std::move(t_s);
  }
  return document;
}

}  // namespace soak::station
