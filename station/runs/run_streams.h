// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/position.h"
#include "db/run/run_file.h"

namespace soak::station {

/// Names of the streams of a run file: a unit's samples, and of the positions that occur in them those beyond the six
/// named ones, or of known azimuth (one row per position, at the time of its first row: label, up vector and, where one
/// of them has it, the rate that the fixture turns at, and the azimuth).
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
/// Adds that stream for `positions`, without a row. Refuses as RunFileWriter::add_stream() does.
[[nodiscard]] base::Result<std::size_t> add_position_stream(db::RunFileWriter& file, std::string_view unit,
                                                            std::span<const calib::Position> positions);
/// Appends the row of positions[index], which occurs from `t_s` on, to the stream that was added for `positions`.
[[nodiscard]] base::Status append_position(db::RunFileWriter& file, std::size_t stream,
                                           std::span<const calib::Position> positions, std::size_t index, double t_s);
/// The positions that were written so; none where there is no such stream.
[[nodiscard]] base::Result<std::vector<calib::Position>> read_positions(const db::RunFileReader& file,
                                                                        std::string_view unit);

/// The position of a label: one of the six, or one of `defined`. Refuses (corrupt, naming `run_id`) another.
[[nodiscard]] base::Result<calib::Position> position_of_label(const std::string& label,
                                                              const std::vector<calib::Position>& defined,
                                                              const std::string& run_id);

}  // namespace soak::station
