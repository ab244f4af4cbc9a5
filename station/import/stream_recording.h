// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

#include "base/result.h"
#include "hal/imu/imu.h"
#include "station/import/source_recording.h"

namespace soak::station {

/// How to read the bytes that a unit once sent.
struct StreamOptions {
  hal::UnitDecoder decoder = hal::UnitDecoder::xsens;
  hal::Ahrs400Ranges ranges = {};  ///< for ahrs400 only
  double rate_hz = 100.0;          ///< that the unit was set to: lost packets are told from a restart by it
  /// Called now and then with the share of the file that is read (0..1); returning false stops the reading.
  std::function<bool(double)> progress;
};

/// Decodes a file of bytes as a unit has sent them (a vendor's log, a capture of its serial line): one run per
/// power-on, called as the file's stem, with a number behind it where there are several. Each run is one attitude
/// throughout, as a CSV file without positions. Packets lost by the unit's own counter, and bytes that belong to no
/// packet, are warnings. Refuses (bad_input) a file in which nothing can be decoded, and a run without any temperature.
[[nodiscard]] base::Result<SourceRecording> read_stream_recording(const std::filesystem::path& path,
                                                                  const StreamOptions& options);

}  // namespace soak::station
