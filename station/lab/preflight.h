// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "calib/vocabulary/unit_type.h"
#include "station/lab/segment_capture.h"

namespace soak::station {

/// What one unit showed in one position of the pre-flight.
struct PreflightRecord {
  std::string unit;
  std::string position;
  calib::UnitType type;
  double asked_rate_hz = 0.0;  ///< by the procedure
  double rate_hz = 0.0;        ///< samples per second of device time
  std::size_t samples = 0;
  std::size_t clipped = 0;
  std::uint64_t lost_packets = 0;  ///< since the run began
  std::array<SampleSpread, calib::kSensorCount> spread;
};

/// What would spoil the campaign, one line per finding: a sensor that is stuck, noisier than its type allows or far
/// from zero or whose readings are not all numbers, a rail that was touched, packets lost (more than 1 in 1000), too
/// few samples, a rate that is off the one that was asked for by more than a half (a unit that obeys another divisor;
/// those with a rate of their own stay within). Serial numbers and signs have been checked before: they stop the
/// pre-flight where they are wrong.
[[nodiscard]] std::vector<std::string> preflight_findings(const std::vector<PreflightRecord>& records);

/// What a campaign will write to the disk, on the safe side: run files compress, catalog and temporary files do not.
[[nodiscard]] double estimated_bytes(double rate_hz, std::size_t units, double seconds);

}  // namespace soak::station
