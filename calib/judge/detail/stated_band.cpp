// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/stated_band.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/statistics.h"

namespace soak::calib::verification {
namespace {

constexpr double kBand = 0.95;
constexpr double kNormalBand = 1.96;  ///< kBand of a normal distribution, two-sided

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

double half_width(double band, double standard_error) { return std::hypot(band, kNormalBand * standard_error); }

BandComparison compare(const std::vector<Ratio>& ratios, std::size_t file_runs) {
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

double largest_ratio(std::size_t file_runs, std::size_t comparisons) {
  const double freedoms = std::max(1.0, static_cast<double>(file_runs) - 1.0);
  const double judgement = 1.0 - kFalseAlarm / static_cast<double>(comparisons);
  return base::student_t_two_sided(judgement, freedoms) / base::student_t_two_sided(kBand, freedoms);
}

std::optional<BandComparison> compare_fresh(const std::vector<RowError>& rows, const UncertaintyTable& table,
                                            std::size_t file_runs) {
  if (table.pi95.empty() || rows.empty()) return std::nullopt;
  std::vector<Ratio> ratios;
  for (const RowError& row : rows) {
    ratios.push_back({row.error, half_width(interpolate(table.temp_c, table.pi95, row.temp_c), row.standard_error)});
  }
  return compare(ratios, file_runs);
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
  return compare(ratios, file_runs);
}

}  // namespace soak::calib::verification
