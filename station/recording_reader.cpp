// SPDX-License-Identifier: Apache-2.0
#include "station/recording_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "calib/sensor.h"
#include "station/channel_units.h"
#include "station/header_name.h"
#include "station/run_streams.h"

namespace soak::station {
namespace {

/// Median distance in time between neighbouring values that are present; 0 where there are fewer than two.
double median_spacing_s(std::span<const double> t_s, const std::vector<double>& values) {
  std::vector<double> spacing;
  std::optional<double> last;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (last) spacing.push_back(t_s[i] - *last);
    last = t_s[i];
  }
  if (spacing.empty()) return 0.0;
  const auto middle = spacing.begin() + static_cast<std::ptrdiff_t>(spacing.size() / 2);
  std::nth_element(spacing.begin(), middle, spacing.end());
  return *middle;
}

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

/// The numbered label of each row; -1 where the cell is empty.
std::vector<std::int32_t> label_numbers(const db::Column& column) {
  std::vector<std::int32_t> numbers;
  numbers.reserve(column.rows());
  for (const double value : db::values_of(column, 1.0, 0.0)) {
    numbers.push_back(std::isnan(value) ? -1 : static_cast<std::int32_t>(value));
  }
  return numbers;
}

/// Maps each row's label to a value; `table` has one entry per label, `empty` is for rows without one.
template <class T>
std::vector<T> by_label(const std::vector<std::int32_t>& numbers, const std::vector<T>& table, T empty) {
  std::vector<T> result(numbers.size(), empty);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= 0 && static_cast<std::size_t>(numbers[i]) < table.size()) {
      result[i] = table[static_cast<std::size_t>(numbers[i])];
    }
  }
  return result;
}

class RecordingReader {
 public:
  RecordingReader(const db::RunFileReader& file, std::string_view unit) : file_(file), unit_(unit) {}

  base::Result<calib::Recording> read() {
    const auto stream = imu_stream(file_, unit_);
    if (!stream) return base::forward_error(stream);
    recording_.run_id = file_.info().run_id;
    recording_.unit = unit_;
    const auto& channels = file_.streams()[*stream].channels;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const auto column = file_.read(*stream, i);
      if (!column) return base::forward_error(column);
      if (auto status = add_channel(channels[i], *column); !status) return base::forward_error(status);
    }
    return std::move(recording_);
  }

 private:
  base::Status add_channel(const db::ChannelInfo& channel, const db::Column& column) {
    if (channel.unit == "label") return add_labels(channel, column);
    std::vector<double> values = db::values_of(column, channel.scale, channel.offset);
    const Conversion convert = conversion_to_si(channel.unit);
    for (double& value : values) value = convert(value);
    if (channel.name == "t_s") {
      recording_.t_s = std::move(values);
    } else if (const auto sensor = calib::sensor_named(channel.name)) {
      recording_.sensor[calib::index_of(*sensor)] = std::move(values);
    } else {
      add_slow_channel(channel.name, std::move(values));
    }
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

  base::Status add_labels(const db::ChannelInfo& channel, const db::Column& column) {
    const std::vector<std::int32_t> numbers = label_numbers(column);
    if (channel.name == "phase") {
      std::vector<calib::Phase> table;
      for (const std::string& label : channel.labels) {
        table.push_back(label == "ramp" ? calib::Phase::ramp : calib::Phase::soak);
      }
      recording_.phase = by_label(numbers, table, calib::Phase::soak);
    } else if (channel.name == "sweep") {
      std::vector<calib::Sweep> table;
      for (const std::string& label : channel.labels) table.push_back(calib::sweep_named(label));
      recording_.sweep = by_label(numbers, table, calib::Sweep::unknown);
    } else if (channel.name == "position") {
      return add_position(channel.labels, numbers);
    }
    return {};
  }

  base::Status add_position(const std::vector<std::string>& labels, const std::vector<std::int32_t>& numbers) {
    const auto defined = read_positions(file_, unit_);
    if (!defined) return base::forward_error(defined);
    std::vector<bool> occurs(labels.size(), false);
    for (const std::int32_t number : numbers) {
      if (number >= 0 && static_cast<std::size_t>(number) < labels.size())
        occurs[static_cast<std::size_t>(number)] = true;
    }
    std::vector<std::int32_t> table;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (!occurs[i]) {
        table.push_back(-1);
        continue;
      }
      const std::string& label = labels[i];
      auto position = calib::position_named(label);
      const auto own = std::find_if(defined->begin(), defined->end(), [&](const auto& p) { return p.label == label; });
      if (own != defined->end()) position = *own;
      if (!position) {
        return base::corrupt(fmt::format("the run file does not define its position '{}'", label), file_.info().run_id);
      }
      // Two spellings of one position ("+x", "+X") are one position.
      const auto same = std::find(recording_.positions.begin(), recording_.positions.end(), *position);
      table.push_back(static_cast<std::int32_t>(same - recording_.positions.begin()));
      if (same == recording_.positions.end()) recording_.positions.push_back(*std::move(position));
    }
    recording_.position = by_label(numbers, table, -1);
    return {};
  }

  const db::RunFileReader& file_;
  std::string unit_;
  calib::Recording recording_;
};

}  // namespace

void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values) {
  const double limit_s = std::max(kHold_s, 1.5 * median_spacing_s(t_s, values));
  double last = std::numeric_limits<double>::quiet_NaN();
  double last_t_s = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) {
      last = values[i];
      last_t_s = t_s[i];
    } else if (t_s[i] - last_t_s <= limit_s) {
      values[i] = last;
    }
  }
}

base::Result<calib::Recording> read_recording(const db::RunFileReader& file, std::string_view unit) {
  return RecordingReader(file, unit).read();
}

}  // namespace soak::station
