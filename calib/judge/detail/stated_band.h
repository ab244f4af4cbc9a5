// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/judge/detail/row_errors.h"
#include "calib/judge/verification.h"

namespace soak::calib::verification {

/// Chance that a right file is called too narrow somewhere.
inline constexpr double kFalseAlarm = 0.01;

/// Largest ratio that is put down to chance in each of `comparisons` bands (1 or more) of one file.
[[nodiscard]] double largest_ratio(std::size_t file_runs, std::size_t comparisons);

/// Errors against pi95 and the rows' own uncertainty in quadrature; nothing where the file states no such band. Judged
/// as the only comparison of the file, as the next one is.
[[nodiscard]] std::optional<BandComparison> compare_fresh(const std::vector<RowError>& rows,
                                                          const UncertaintyTable& table, std::size_t file_runs);

/// Means per temperature, run offsets removed, against ci95 and their own uncertainty in quadrature; nothing with fewer
/// than two temperatures.
[[nodiscard]] std::optional<BandComparison> compare_shape(std::vector<RowError> rows, const UncertaintyTable& table,
                                                          std::size_t file_runs);

}  // namespace soak::calib::verification
