// SPDX-License-Identifier: Apache-2.0
#include "station/import/source_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "hal/imu/imu.h"
#include "station/runs/run_columns.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using ImuSamples = std::span<const hal::ImuSample>;

/// Of a thermometer that comes with every packet: it tells nothing new of a body that takes minutes to warm.
constexpr double kTempRate_hz = 10.0;

/// All samples of the file.
base::Result<std::vector<hal::ImuSample>> decode(hal::Imu& imu, const fs::path& path, const StreamOptions& options) {
  std::error_code failure;
  const auto size = fs::file_size(path, failure);
  if (failure) return base::bad_input(failure.message(), path.string());
  const auto opened = imu.open({options.rate_hz, std::min(kTempRate_hz, options.rate_hz)});
  if (!opened) return base::bad_input(opened.error().message, path.string());
  std::vector<hal::ImuSample> samples;
  double read_bytes = 0.0;
  while (true) {
    const base::Status more = imu.poll(samples);
    if (!more && more.error().message == hal::kRecordingEnded) return samples;
    if (!more) return base::bad_input(more.error().message, path.string());
    read_bytes += hal::kBytesPerPoll;
    if (options.progress && !options.progress(std::min(1.0, read_bytes / static_cast<double>(size)))) {
      return base::fail(base::ErrorKind::internal, "interrupted: nothing was imported", path.string());
    }
  }
}

/// The channels that a unit fills by itself.
bool is_own(const db::ChannelInfo& channel) {
  constexpr std::array<std::string_view, 4> kOwn = {"t_s", "temp_c", "packet", "status"};
  return std::ranges::find(kOwn, channel.name) != kOwn.end() || channel.name.starts_with("gyro_") ||
         channel.name.starts_with("accel_");
}

SourceRun run_of(ImuSamples samples, std::string label) {
  SourceRun run{std::move(label), 0, {}, {}, {}};
  auto channels = imu_channels(false, false);
  auto columns = imu_columns(samples, {}, {}, {}, false);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (!is_own(channels[i])) continue;
    run.channels.push_back(std::move(channels[i]));
    run.columns.push_back(std::move(columns[i]));
  }
  return run;
}

/// The samples of each power-on.
std::vector<ImuSamples> power_ons(ImuSamples samples) {
  std::vector<ImuSamples> parts;
  while (!samples.empty()) {
    const auto other = [&](const hal::ImuSample& sample) { return sample.power_on != samples.front().power_on; };
    const auto count = static_cast<std::size_t>(std::ranges::find_if(samples, other) - samples.begin());
    parts.push_back(samples.first(count));
    samples = samples.subspan(count);
  }
  return parts;
}

void warn_of_losses(const hal::ImuStatistics& statistics, const fs::path& path, SourceRecording& recording) {
  if (statistics.lost_packets > 0) {
    recording.warnings.push_back(fmt::format("{}: {} packets of {} were lost, by the unit's own counter", path.string(),
                                             statistics.lost_packets, statistics.lost_packets + statistics.packets));
  }
  if (statistics.garbage_bytes > 0) {
    recording.warnings.push_back(
        fmt::format("{}: {} bytes are not part of any packet", path.string(), statistics.garbage_bytes));
  }
}

}  // namespace

base::Result<SourceRecording> read_stream_recording(const fs::path& path, const StreamOptions& options) {
  const auto imu = hal::make_imu({hal::RecordedAddress{path.string()}, options.decoder, options.ranges});
  const auto samples = decode(*imu, path, options);
  if (!samples) return base::forward_error(samples);
  const auto parts = power_ons(*samples);
  if (parts.empty()) {
    return base::bad_input("no packet with rates and accelerations: is this another protocol (--decoder)?",
                           path.string());
  }
  SourceRecording recording;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string stem = path.stem().string();
    std::string label = parts.size() == 1 ? stem : fmt::format("{} {}", stem, i + 1);
    if (std::ranges::none_of(parts[i], [](const auto& sample) { return sample.temp_c.has_value(); })) {
      return base::bad_input(fmt::format("run '{}' has no temperature: set the unit to send it", label), path.string());
    }
    recording.runs.push_back(run_of(parts[i], std::move(label)));
  }
  warn_of_losses(imu->statistics(), path, recording);
  return recording;
}

}  // namespace soak::station
