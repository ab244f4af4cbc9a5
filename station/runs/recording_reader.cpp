// SPDX-License-Identifier: Apache-2.0
#include "station/runs/recording_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "calib/vocabulary/sensor.h"
#include "station/import/channel.h"
#include "station/import/slow_channel.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

/// Fills empty rows so that the difference to `t_s` stays that of the nearest value before, or of the first one.
void run_on_with_time(std::span<const double> t_s, std::vector<double>& values) {
  const auto first = std::find_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  if (first == values.end()) {
    values.clear();
    return;
  }
  double lead = *first - t_s[static_cast<std::size_t>(first - values.begin())];
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) lead = values[i] - t_s[i];
    values[i] = t_s[i] + lead;
  }
}

/// Reads one channel, converted to SI, into `values`, whose memory is used again.
base::Status read_channel(const db::RunFileReader& file, std::size_t stream, std::size_t channel,
                          std::vector<double>& values) {
  const Conversion convert = conversion_to_si(file.streams()[stream].channels[channel].unit);
  const bool is_si = convert == conversion_to_si("");  // nothing to call for each value
  values.clear();
  values.reserve(file.rows(stream));
  return file.scan(stream, channel, [&](std::span<const double> chunk) {
    const auto last = values.insert(values.end(), chunk.begin(), chunk.end());
    if (!is_si) std::transform(last, values.end(), last, convert);
  });
}

/// Reads a channel of labels: for each row what `value` makes of the number of its label, -1 where the cell is empty.
template <class T, class Value>
base::Status read_labels(const db::RunFileReader& file, std::size_t stream, std::size_t channel, std::vector<T>& values,
                         const Value& value) {
  values.clear();
  values.reserve(file.rows(stream));
  return file.scan(stream, channel, [&](std::span<const double> chunk) {
    for (auto first = chunk.begin(); first != chunk.end();) {
      const double number = *first;  // labels stay the same for long
      const auto last = std::find_if(first + 1, chunk.end(), [&](double other) { return !(other == number); });
      const T meaning = value(std::isnan(number) ? std::int32_t{-1} : static_cast<std::int32_t>(number));
      values.insert(values.end(), static_cast<std::size_t>(last - first), meaning);
      first = last;
    }
  });
}

/// The same, by a table of one value per label; `empty` where there is none.
template <class T>
base::Status read_labels(const db::RunFileReader& file, std::size_t stream, std::size_t channel, std::vector<T>& values,
                         const std::vector<T>& table, T empty) {
  return read_labels(file, stream, channel, values, [&](std::int32_t number) {
    const bool known = number >= 0 && static_cast<std::size_t>(number) < table.size();
    return known ? table[static_cast<std::size_t>(number)] : empty;
  });
}

/// All but the sensors.
class AxesReader {
 public:
  AxesReader(const db::RunFileReader& file, std::string_view unit, std::size_t stream)
      : file_(file), unit_(unit), stream_(stream) {}

  base::Result<calib::Recording> read() {
    recording_.run_id = file_.info().run_id;
    recording_.unit = unit_;
    const auto& channels = file_.streams()[stream_].channels;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (auto status = add_channel(channels[i], i); !status) return base::forward_error(status);
    }
    const auto split = split_by_rate(recording_, std::move(rate_rps_), file_.info().label);
    if (!split) return base::forward_error(split);
    return std::move(recording_);
  }

 private:
  base::Status add_channel(const db::ChannelInfo& channel, std::size_t index) {
    if (channel.unit == "label") return add_labels(channel, index);
    if (calib::sensor_named(channel.name)) return {};
    if (channel.name == "t_s") return read_channel(file_, stream_, index, recording_.t_s);
    if (is_fixture_rate(channel)) return read_channel(file_, stream_, index, rate_rps_);
    std::vector<double> values;
    if (auto status = read_channel(file_, stream_, index, values); !status) return status;
    add_slow_channel(channel.name, std::move(values));
    return {};
  }

  void add_slow_channel(const std::string& name, std::vector<double> values) {
    if (name == "t_since_power_s") {
      run_on_with_time(recording_.t_s, values);
      recording_.t_since_power_s = std::move(values);
      return;
    }
    hold_slow_channel(recording_.t_s, values);
    if (name == "temp_c") {
      recording_.temp_c = std::move(values);
    } else if (name == "plateau_c") {
      recording_.plateau_c = std::move(values);
    } else if (const auto sensor = sensor_of_thermometer(name)) {
      recording_.sensor_temp_c[calib::index_of(*sensor)] = std::move(values);
    } else {
      recording_.auxiliary.push_back({name, std::move(values)});
    }
  }

  static std::optional<calib::Sensor> sensor_of_thermometer(std::string_view name) {
    for (const calib::Sensor sensor : calib::kSensors) {
      const std::string header = canonical_header(calib::name_of(sensor));
      if (name == fmt::format("temp_{}_c", header.substr(0, 2))) return sensor;
    }
    return std::nullopt;
  }

  base::Status add_labels(const db::ChannelInfo& channel, std::size_t index) {
    if (channel.name == "phase") {
      std::vector<calib::Phase> table;
      for (const std::string& label : channel.labels) {
        table.push_back(label == "ramp" ? calib::Phase::ramp : calib::Phase::soak);
      }
      return read_labels(file_, stream_, index, recording_.phase, table, calib::Phase::soak);
    }
    if (channel.name == "sweep") {
      std::vector<calib::Sweep> table;
      for (const std::string& label : channel.labels) table.push_back(calib::sweep_named(label));
      return read_labels(file_, stream_, index, recording_.sweep, table, calib::Sweep::unknown);
    }
    return channel.name == "position" ? add_position(channel.labels, index) : base::Status();
  }

  base::Status add_position(const std::vector<std::string>& labels, std::size_t index) {
    std::vector<bool> occurs(labels.size(), false);
    auto read = read_labels(file_, stream_, index, recording_.position, [&](std::int32_t number) {
      const bool known = number >= 0 && static_cast<std::size_t>(number) < labels.size();
      if (known) occurs[static_cast<std::size_t>(number)] = true;
      return known ? number : -1;
    });
    if (!read) return read;
    const auto table = position_table(labels, occurs);
    if (!table) return base::forward_error(table);
    for (std::int32_t& position : recording_.position) {
      if (position >= 0) position = (*table)[static_cast<std::size_t>(position)];
    }
    return {};
  }

  /// Index into the recording's positions of each label that occurs.
  base::Result<std::vector<std::int32_t>> position_table(const std::vector<std::string>& labels,
                                                         const std::vector<bool>& occurs) {
    const auto defined = read_positions(file_, unit_);
    if (!defined) return base::forward_error(defined);
    std::vector<std::int32_t> table;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (!occurs[i]) {
        table.push_back(-1);
        continue;
      }
      auto position = position_of_label(labels[i], *defined, file_.info().run_id);
      if (!position) return base::forward_error(position);
      // Two spellings of one position ("+x", "+X") are one position.
      const auto same = std::find(recording_.positions.begin(), recording_.positions.end(), *position);
      table.push_back(static_cast<std::int32_t>(same - recording_.positions.begin()));
      if (same == recording_.positions.end()) recording_.positions.push_back(*std::move(position));
    }
    return table;
  }

  const db::RunFileReader& file_;
  std::string unit_;
  std::size_t stream_;
  calib::Recording recording_;
  std::vector<double> rate_rps_;
};

}  // namespace

base::Result<calib::Recording> read_axes(const db::RunFileReader& file, std::string_view unit) {
  const auto stream = imu_stream(file, unit);
  if (!stream) return base::forward_error(stream);
  return AxesReader(file, unit, *stream).read();
}

base::Status read_sensor(const db::RunFileReader& file, std::string_view unit, calib::Sensor sensor,
                         std::vector<double>& values) {
  const auto stream = imu_stream(file, unit);
  if (!stream) return base::forward_error(stream);
  values.clear();
  const auto channel = find_channel(file.streams()[*stream].channels, calib::name_of(sensor));
  return channel ? read_channel(file, *stream, *channel, values) : base::Status();
}

base::Result<calib::Recording> read_recording(const db::RunFileReader& file, std::string_view unit) {
  auto recording = read_axes(file, unit);
  if (!recording) return recording;
  for (const calib::Sensor sensor : calib::kSensors) {
    auto status = read_sensor(file, unit, sensor, recording->sensor[calib::index_of(sensor)]);
    if (!status) return base::forward_error(status);
  }
  return recording;
}

}  // namespace soak::station
