// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/position.h"
#include "db/run_file.h"

namespace soak::station {

/// Names of the streams of a run file: a unit's samples, and the positions beyond the six named ones that occur in them
/// (one row per position, at the time of its first row: label, up vector and, where the fixture turns in one of them,
/// rate).
inline constexpr std::string_view kImuStream = "imu";
inline constexpr std::string_view kPositionsStream = "positions";

/// Index of a unit's stream.
[[nodiscard]] std::optional<std::size_t> find_stream(const db::RunFileReader& file, std::string_view name,
                                                     std::string_view unit);
/// Index of a channel by its canonical name.
[[nodiscard]] std::optional<std::size_t> find_channel(const std::vector<db::ChannelInfo>& channels,
                                                      std::string_view name);

/// The unit's samples; refuses (bad_input) a run file that has none.
[[nodiscard]] base::Result<std::size_t> imu_stream(const db::RunFileReader& file, std::string_view unit);

/// Writes `positions`, which occur in the column `position` of the samples, as a stream of its own.
[[nodiscard]] base::Status write_positions(db::RunFileWriter& file, std::string_view unit,
                                           const std::vector<calib::Position>& positions,
                                           const std::vector<db::ChannelInfo>& channels,
                                           const std::vector<db::Column>& columns);
/// The positions that write_positions() wrote; none where there is no such stream.
[[nodiscard]] base::Result<std::vector<calib::Position>> read_positions(const db::RunFileReader& file,
                                                                        std::string_view unit);

}  // namespace soak::station
