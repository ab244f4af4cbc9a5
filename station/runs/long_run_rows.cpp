// SPDX-License-Identifier: Apache-2.0
#include "station/runs/long_run_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/vocabulary/sensor.h"
#include "station/import/slow_channel.h"
#include "station/runs/run_columns.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr std::size_t kBlockRows = 65536;
/// Channels with values in some rows only, which hold.
constexpr std::array kHeldChannels = {std::string_view("plateau_c"), std::string_view("temp_c"), kVisitChannel};

bool needs_whole_run(const db::ChannelInfo& channel) {
  const bool own_thermometer = channel.name.starts_with("temp_") && channel.name != "temp_c";
  return is_fixture_rate(channel) || channel.name == "t_since_power_s" || own_thermometer;
}

/// Number of a row's label; nothing where it has none, or an unknown one.
std::optional<std::size_t> label_number(double value, std::size_t labels) {
  if (!(value >= 0.0) || value >= static_cast<double>(labels)) return std::nullopt;
  return static_cast<std::size_t>(value);
}

}  // namespace

base::Result<std::unique_ptr<LongRunRows>> LongRunRows::open(const db::RunFileReader& file, std::string_view unit) {
  const auto stream = imu_stream(file, unit);
  if (!stream) return base::forward_error(stream);
  std::unique_ptr<LongRunRows> rows(new LongRunRows(file, unit, *stream));
  const auto& channels = file.streams()[*stream].channels;
  if (std::ranges::any_of(channels, needs_whole_run)) return nullptr;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Conversion to_si = conversion_to_si(channels[i].unit);
    rows->channels_[channels[i].name] = {i, to_si, to_si == conversion_to_si("")};
    if (channels[i].unit == "label") rows->labels_[channels[i].name] = channels[i].labels;
  }
  for (const std::string_view needed : {"t_s", "temp_c", "plateau_c", "position", "phase"}) {
    if (rows->channel_named(needed) == nullptr) return nullptr;
  }
  auto defined = read_positions(file, unit);
  if (!defined) return base::forward_error(defined);
  rows->defined_ = *std::move(defined);
  if (auto found = rows->find_hold_limits(); !found) return base::forward_error(found);
  return rows;
}

const LongRunRows::Channel* LongRunRows::channel_named(std::string_view name) const {
  const auto found = channels_.find(name);
  return found == channels_.end() ? nullptr : &found->second;
}

base::Status LongRunRows::find_hold_limits() {
  std::vector<double> t_s;
  std::vector<double> values;
  for (const std::string_view name : kHeldChannels) {
    if (channel_named(name) == nullptr) continue;
    HoldLimit limit;
    for (std::size_t first = 0; first < rows_; first += kBlockRows) {
      const std::size_t last = std::min(first + kBlockRows, rows_);
      if (auto status = read("t_s", first, last, t_s); !status) return status;
      if (auto status = read(name, first, last, values); !status) return status;
      limit.add(t_s, values);
    }
    channels_.find(name)->second.hold_s = limit.limit_s();
  }
  return {};
}

base::Status LongRunRows::read_block(Channel& channel, std::size_t block) {
  if (channel.block == block) return {};
  channel.block.reset();
  const auto column = file_.read(stream_, channel.index, block * kBlockRows, kBlockRows);
  if (!column) return base::forward_error(column);
  const db::ChannelInfo& info = file_.streams()[stream_].channels[channel.index];
  channel.values.resize(column->rows());
  db::put_values(*column, 0, info.scale, info.offset, channel.values);
  if (!channel.is_si) std::ranges::transform(channel.values, channel.values.begin(), channel.to_si);
  channel.block = block;
  return {};
}

base::Status LongRunRows::read(std::string_view name, std::size_t first, std::size_t last,
                               std::vector<double>& values) {
  Channel& channel = channels_.find(name)->second;
  values.clear();
  values.reserve(last - first);
  while (first < last) {
    const std::size_t block = first / kBlockRows;
    if (auto status = read_block(channel, block); !status) return status;
    const std::size_t from = first - block * kBlockRows;
    const std::size_t count = std::min(channel.values.size() - from, last - first);
    const auto begin = channel.values.begin() + static_cast<std::ptrdiff_t>(from);
    values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    first += count;
  }
  return {};
}

/// A value from before `first` may hold until after it: rows are read from so early that no older one can.
base::Status LongRunRows::read_held(std::string_view name, std::size_t first, std::size_t last,
                                    std::vector<double>& values) {
  const double hold_s = channel_named(name)->hold_s;
  std::vector<double>& t_s = scratch_;
  std::size_t before = 0;
  for (std::size_t more = 512;; more *= 2) {
    before = std::min(more, first);
    if (auto status = read("t_s", first - before, last, t_s); !status) return status;
    if (before == first || t_s[before] - t_s.front() > hold_s) break;
  }
  if (auto status = read(name, first - before, last, values); !status) return status;
  hold_slow_channel(t_s, values, hold_s);
  values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(before));
  return {};
}

base::Status LongRunRows::read_labels(std::size_t first, std::size_t last, calib::Recording& recording) {
  std::vector<double> numbers;
  if (auto status = read("phase", first, last, numbers); !status) return status;
  const auto& phases = labels_.find("phase")->second;
  for (const double number : numbers) {
    const auto label = label_number(number, phases.size());
    recording.phase.push_back(label && phases[*label] == "ramp" ? calib::Phase::ramp : calib::Phase::soak);
  }
  if (!labels_.contains("sweep")) return {};
  if (auto status = read("sweep", first, last, numbers); !status) return status;
  const auto& sweeps = labels_.find("sweep")->second;
  for (const double number : numbers) {
    const auto label = label_number(number, sweeps.size());
    recording.sweep.push_back(label ? calib::sweep_named(sweeps[*label]) : calib::Sweep::unknown);
  }
  return {};
}

base::Status LongRunRows::read_positions_of(std::size_t first, std::size_t last, calib::Recording& recording) {
  std::vector<double> numbers;
  if (auto status = read("position", first, last, numbers); !status) return status;
  const auto& labels = labels_.find("position")->second;
  std::map<std::size_t, std::int32_t> known;
  for (const double number : numbers) {
    const auto label = label_number(number, labels.size());
    if (label && !known.contains(*label)) {
      const auto position = position_of_label(labels[*label], defined_, file_.info().run_id);
      if (!position) return base::forward_error(position);
      const auto same = std::ranges::find(recording.positions, *position);
      known[*label] = static_cast<std::int32_t>(same - recording.positions.begin());
      if (same == recording.positions.end()) recording.positions.push_back(*position);
    }
    recording.position.push_back(label ? known[*label] : -1);
  }
  return {};
}

base::Result<calib::Recording> LongRunRows::axes(std::size_t first, std::size_t last) {
  calib::Recording recording;
  recording.run_id = file_.info().run_id;
  recording.unit = unit_;
  base::Status status = read_labels(first, last, recording);
  if (status) status = read_positions_of(first, last, recording);
  if (status) status = read_held("temp_c", first, last, recording.temp_c);
  if (status) status = read_held("plateau_c", first, last, recording.plateau_c);
  if (status && channel_named(kVisitChannel) != nullptr) {
    auto& visits = recording.auxiliary.emplace_back(calib::AuxiliaryChannel{std::string(kVisitChannel), {}});
    status = read_held(kVisitChannel, first, last, visits.values);
  }
  if (status) status = read("t_s", first, last, recording.t_s);
  if (!status) return base::forward_error(status);
  return recording;
}

base::Status LongRunRows::samples(calib::Sensor sensor, std::size_t first, std::size_t last,
                                  std::vector<double>& values) {
  return read(calib::name_of(sensor), first, last, values);
}

}  // namespace soak::station
