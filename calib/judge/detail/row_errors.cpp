// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/row_errors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/statistics.h"
#include "calib/estimate/uncertainty_budget.h"

namespace soak::calib::verification {
namespace {

/// Estimates at the very ends of the range scatter across it by the thermometer's noise.
constexpr double kSlack_c = 0.5;
constexpr double kCell_c = 1.5;
constexpr std::size_t kFewestDifferences = 5;

using Rows = std::vector<RowError>;

/// Groups rows that are sorted by temperature.
std::vector<Rows> grouped(const Rows& rows) {
  std::vector<Rows> groups;
  for (const RowError& row : rows) {
    if (groups.empty() || row.temp_c - groups.back().front().temp_c > kCell_c) groups.emplace_back();
    groups.back().push_back(row);
  }
  return groups;
}

Cell mean_of(const Rows& rows) {
  const auto count = static_cast<double>(rows.size());
  Cell cell{0.0, 0.0, 0.0};
  double variance = 0.0;
  for (const RowError& row : rows) {
    cell.temp_c += row.temp_c / count;
    cell.error += row.error / count;
    variance += row.standard_error * row.standard_error;
  }
  cell.standard_error = std::sqrt(variance) / count;
  return cell;
}

/// Variance of single rows about their cells; 0 where no cell has two rows.
double scatter_about(const std::vector<Cell>& cells, const std::vector<Rows>& groups) {
  double squares = 0.0;
  double freedoms = 0.0;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (const RowError& row : groups[c]) squares += (row.error - cells[c].error) * (row.error - cells[c].error);
    freedoms += static_cast<double>(groups[c].size()) - 1.0;
  }
  return freedoms > 0.0 ? squares / freedoms : 0.0;
}

/// What wanders from visit to visit beyond the rows' standard errors; 0 where there is nothing, or it cannot be told.
struct SlowScatter {
  double variance = 0.0;
  double freedoms = 0.0;
};
SlowScatter slow_scatter(const Rows& rows) {
  std::vector<double> differences;
  double own = 0.0;
  for (const RowError& row : rows) {
    own += row.standard_error * row.standard_error / static_cast<double>(rows.size());
  }
  for (std::size_t i = 2; i < rows.size(); ++i) {
    if (rows[i - 2].run != rows[i].run || rows[i - 1].run != rows[i].run) continue;
    differences.push_back(std::abs(rows[i - 2].error - 2.0 * rows[i - 1].error + rows[i].error));
  }
  if (differences.size() < kFewestDifferences) return {};
  // A second difference of independent errors has six times their variance; of Gaussian ones median |d| = 0.6745 σ_d.
  const double sigma = base::median(differences) / (0.6745 * std::sqrt(6.0));
  return {std::max(0.0, sigma * sigma - own), 0.5 * static_cast<double>(differences.size())};
}

// ---- bands ----

constexpr double kBandCoverage = 0.95;
constexpr double kNormalQuantile = 1.96;  ///< kBandCoverage of a normal distribution, two-sided

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  return std::lerp(y[i - 1], y[i], (at - x[i - 1]) / (x[i] - x[i - 1]));
}

/// An error and the half-width that it should keep within in 95 of 100 cases.
struct Ratio {
  double error;
  double half_width;
};

double half_width(double band, double standard_error) { return std::hypot(band, kNormalQuantile * standard_error); }

BandComparison compare_ratios(const std::vector<Ratio>& ratios, std::size_t file_runs) {
  BandComparison result;
  double squares = 0.0;
  double inside = 0.0;
  for (const Ratio& r : ratios) {
    inside += std::abs(r.error) <= r.half_width ? 1.0 : 0.0;
    if (r.error != 0.0) squares += (r.error / r.half_width) * (r.error / r.half_width);
  }
  const auto count = static_cast<double>(ratios.size());
  result.inside = inside / count;
  result.ratio = std::sqrt(squares / count);
  result.ratio_max = largest_ratio(file_runs, 1);
  return result;
}

}  // namespace

RowErrors errors_of(const Curve& curve, double temp_min_c, double temp_max_c, const CurveData& data) {
  RowErrors result;
  for (const CurveRow& row : data.rows) {
    if (row.temp_c < temp_min_c - kSlack_c || row.temp_c > temp_max_c + kSlack_c) {
      ++result.out_of_range;
      continue;
    }
    result.rows.push_back({row.run, row.temp_c, row.value - evaluate(curve, row.temp_c), row.standard_error});
  }
  const SlowScatter slow = slow_scatter(result.rows);
  for (RowError& row : result.rows) {
    row.slow_error = std::sqrt(slow.variance);
    row.slow_freedoms = slow.freedoms;
    row.standard_error = std::hypot(row.standard_error, row.slow_error);
  }
  return result;
}

double expanded(const RowError& row, double common_u) {
  const double noise_variance = row.standard_error * row.standard_error - row.slow_error * row.slow_error;
  return expanded_uncertainty({{.degrees_of_freedom = kNoiseFreedoms, .u = {std::sqrt(std::max(0.0, noise_variance))}},
                               {.degrees_of_freedom = row.slow_freedoms, .u = {row.slow_error}},
                               {.type = 'B', .u = {common_u}}},
                              Band::mean, 0);
}

void remove_run_means(std::vector<RowError>& rows) {
  std::map<int, std::pair<double, double>> sums;
  for (const RowError& row : rows) {
    sums[row.run].first += row.error;
    sums[row.run].second += 1.0;
  }
  for (RowError& row : rows) row.error -= sums[row.run].first / sums[row.run].second;
}

double rms(const std::vector<RowError>& rows) {
  double squares = 0.0;
  for (const RowError& row : rows) squares += row.error * row.error;
  return std::sqrt(squares / static_cast<double>(rows.size()));
}

std::vector<Cell> cells_of(std::vector<RowError> rows) {
  std::sort(rows.begin(), rows.end(), [](const RowError& a, const RowError& b) { return a.temp_c < b.temp_c; });
  const std::vector<Rows> groups = grouped(rows);
  std::vector<Cell> cells;
  for (const Rows& group : groups) cells.push_back(mean_of(group));
  const double scatter = scatter_about(cells, groups);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c].standard_error =
        std::max(cells[c].standard_error, std::sqrt(scatter / static_cast<double>(groups[c].size())));
  }
  return cells;
}

double largest_ratio(std::size_t file_runs, std::size_t comparisons) {
  const double freedoms = std::max(1.0, static_cast<double>(file_runs) - 1.0);
  const double judgement = 1.0 - kFalseAlarm / static_cast<double>(comparisons);
  return base::student_t_two_sided(judgement, freedoms) / base::student_t_two_sided(kBandCoverage, freedoms);
}

std::optional<BandComparison> compare_fresh(const std::vector<RowError>& rows, const UncertaintyTable& table,
                                            std::size_t file_runs) {
  if (table.pi95.empty() || rows.empty()) return std::nullopt;
  std::vector<Ratio> ratios;
  for (const RowError& row : rows) {
    ratios.push_back({row.error, half_width(interpolate(table.temp_c, table.pi95, row.temp_c), row.standard_error)});
  }
  return compare_ratios(ratios, file_runs);
}

std::optional<BandComparison> compare_shape(std::vector<RowError> rows, const UncertaintyTable& table,
                                            std::size_t file_runs) {
  if (table.ci95.empty()) return std::nullopt;
  remove_run_means(rows);
  const std::vector<Cell> cells = cells_of(std::move(rows));
  if (cells.size() < 2) return std::nullopt;
  std::vector<Ratio> ratios;
  for (const Cell& cell : cells) {
    ratios.push_back({cell.error, half_width(interpolate(table.temp_c, table.ci95, cell.temp_c), cell.standard_error)});
  }
  return compare_ratios(ratios, file_runs);
}

}  // namespace soak::calib::verification
