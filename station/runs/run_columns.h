// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/vocabulary/run.h"
#include "calib/vocabulary/segment.h"
#include "db/run/sample.h"
#include "hal/devices/chamber.h"
#include "hal/imu/imu.h"

/// The streams of a run file that the station records (docs/file-formats.md).
namespace soak::station {

/// What the station knows of the rows that it adds.
struct RowLabels {
  calib::Phase phase = calib::Phase::soak;
  calib::Sweep sweep = calib::Sweep::unknown;
  std::optional<double> plateau_c;  ///< set point
  std::string position;             ///< one of the six labels; empty = moving
  int visit = -1;         ///< ordinal of the plateau in the plan; -1 = counted from the changes of `plateau_c`, from 0
  double rate_dps = 0.0;  ///< at which the fixture turns in that position
};

/// Ordinal of the plateau in the plan, where it is known. Segments get their visits from this channel.
inline constexpr std::string_view kVisitChannel = "visit";

/// What came since the last row of a unit from devices that are slower than it.
struct SlowReadings {
  bool with_supply = false;  ///< the stream has the channels of the supply
  std::optional<double> chamber_c;
  std::optional<double> supply_v;
  std::optional<double> supply_a;
};

/// Channels of a unit's stream, and rows for it in that order. `fresh` goes into the first row. `with_supply`: with
/// voltage and current of its supply. `with_rates`: the last channel is the rate of the fixture, where the unit has a
/// position.
[[nodiscard]] std::vector<db::ChannelInfo> imu_channels(bool with_supply, bool with_rates);
[[nodiscard]] std::vector<db::Column> imu_columns(std::span<const hal::ImuSample> samples, const RowLabels& labels,
                                                  std::optional<int> visit, const SlowReadings& fresh, bool with_rates);

/// The same for the chamber's log, one row.
[[nodiscard]] std::vector<db::ChannelInfo> chamber_channels();
[[nodiscard]] std::vector<db::Column> chamber_columns(double t_s, const hal::ChamberReading& reading);

}  // namespace soak::station
