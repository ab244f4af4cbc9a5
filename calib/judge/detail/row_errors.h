// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/estimate/curve_data.h"
#include "calib/judge/verification.h"

namespace soak::calib::verification {

/// A row of a fresh run against a curve of the file.
struct RowError {
  int run;
  double temp_c;
  double error;
  double standard_error;
  double slow_error = 0.0;     ///< the part of it that shows from visit to visit only
  double slow_freedoms = 0.0;  ///< degrees of freedom of that part
};

/// Rows that lie within the range, 0.5 °C of slack at its ends, in the order of their runs and times, and how many do
/// not.
///
/// A row's own standard error knows the noise within its visit. What wanders more slowly (flicker, another settling at
/// each visit) shows from visit to visit only: it is taken from the second differences e₁ − 2 e₂ + e₃ of the errors of
/// neighbouring visits, in which a smooth error of the curve hardly shows, and added to the variance of every row where
/// it exceeds what the rows' own errors make of them. By their median, so that a feature that the curve has missed at
/// one or two temperatures is not taken for scatter. Fewer than five differences: nothing is added. Degrees of freedom:
/// half the number of differences (so wide Student's t makes the 95 % interval of an error beside them, by simulation
/// of 7 to 84 rows: 0.61 to 0.42 of it).
struct RowErrors {
  std::vector<RowError> rows;
  std::size_t out_of_range = 0;
};
[[nodiscard]] RowErrors errors_of(const Curve& curve, double temp_min_c, double temp_max_c, const CurveData& data);

/// Degrees of freedom of a row's own standard error: as many as the run's typical one counts for in it
/// (six_position/problem.cpp), which is the least that it has.
inline constexpr double kNoiseFreedoms = 20.0;

/// U of a row: the 95 % half-width of its own error and of what all rows share, of standard uncertainty `common_u` and
/// known (calib/estimate/uncertainty_budget.h).
[[nodiscard]] double expanded(const RowError& row, double common_u);

/// Takes each run's own mean error out.
void remove_run_means(std::vector<RowError>& rows);

[[nodiscard]] double rms(const std::vector<RowError>& rows);

/// Rows of one temperature over runs and sweeps as one.
struct Cell {
  double temp_c;
  double error;  ///< mean
  /// Of the mean: from the rows' own, or from their scatter about the cells where that is larger.
  double standard_error;
};
/// In the order of temperature; a cell is 1.5 K wide at most.
[[nodiscard]] std::vector<Cell> cells_of(std::vector<RowError> rows);

// ---- against the bands that the file states ----

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
