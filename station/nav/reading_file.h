// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "nav/drive/drive.h"

namespace soak::station {

/// The readings of a unit in a CSV file with one row for each sample; times as they stand there. `names` are those of
/// the columns (docs/csv-format.md), with empty `names` the first line has them. `unit_to_body` turns the unit's axes
/// into body axes. Refuses (bad_input) a file without rows, columns in which the time or one of the six sensors is
/// missing or twice, and a cell that is no number, with its line.
[[nodiscard]] base::Result<std::vector<nav::ImuSample>> read_samples(const std::filesystem::path& path,
                                                                     const std::vector<std::string>& names,
                                                                     const Eigen::Matrix3d& unit_to_body);

}  // namespace soak::station
