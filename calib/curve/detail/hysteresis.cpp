// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/hysteresis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "base/statistics.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

constexpr double kBin_c = 2.5;

/// Weighted mean of residuals.
struct Mean {
  double weight = 0.0;
  double sum = 0.0;

  void add(double w, double value) {
    weight += w;
    sum += w * value;
  }
  [[nodiscard]] double value() const { return sum / weight; }
};

/// Residuals of one run in one bin of temperature.
struct Cell {
  Mean up;
  Mean down;
  Mean temp_c;

  [[nodiscard]] bool both() const { return up.weight > 0.0 && down.weight > 0.0; }
  [[nodiscard]] double difference() const { return up.value() - down.value(); }
  [[nodiscard]] double variance() const { return 1.0 / up.weight + 1.0 / down.weight; }
};

/// Differences of one bin, run by run.
struct Bin {
  std::vector<double> differences;
  double own_variance = 0.0;  ///< mean of the runs' own variances
  double temp_c = 0.0;

  [[nodiscard]] double count() const { return static_cast<double>(differences.size()); }
  [[nodiscard]] double mean() const {
    double sum = 0.0;
    for (const double d : differences) sum += d / count();
    return sum;
  }
};

double typical_error(const CurveData& data) {
  std::vector<double> errors;
  for (const CurveRow& row : data.rows) {
    if (row.standard_error > 0.0) errors.push_back(row.standard_error);
  }
  return errors.empty() ? 0.0 : base::median(errors);
}

std::vector<Bin> collect(const CurveData& data, const Curve& curve, double typical) {
  std::map<std::pair<long, int>, Cell> cells;
  for (const CurveRow& row : data.rows) {
    if (row.sweep == Sweep::unknown) continue;
    const double se = std::max(row.standard_error, typical);
    Cell& cell = cells[{std::lround(row.temp_c / kBin_c), row.run}];
    (row.sweep == Sweep::up ? cell.up : cell.down).add(1.0 / (se * se), row.value - evaluate(curve, row.temp_c));
    cell.temp_c.add(1.0, row.temp_c);
  }
  std::map<long, Bin> bins;
  for (const auto& [key, cell] : cells) {
    if (!cell.both()) continue;
    Bin& bin = bins[key.first];
    bin.differences.push_back(cell.difference());
    bin.own_variance += cell.variance();
    bin.temp_c += cell.temp_c.value();
  }
  std::vector<Bin> list;
  for (auto& [key, bin] : bins) {
    bin.own_variance /= bin.count();
    bin.temp_c /= bin.count();
    list.push_back(std::move(bin));
  }
  return list;
}

/// Variance of one run's difference: pooled scatter between runs, at least what the rows say themselves.
double variance_of_one(const std::vector<Bin>& bins) {
  double squares = 0.0;
  double degrees = 0.0;
  double own = 0.0;
  for (const Bin& bin : bins) {
    own += bin.own_variance / static_cast<double>(bins.size());
    for (const double d : bin.differences) squares += (d - bin.mean()) * (d - bin.mean());
    degrees += bin.count() - 1.0;
  }
  return degrees > 0.0 ? std::max(own, squares / degrees) : own;
}

}  // namespace

std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve) {
  const double typical = typical_error(data);
  if (typical <= 0.0) return std::nullopt;
  const std::vector<Bin> bins = collect(data, curve, typical);
  if (bins.empty()) return std::nullopt;
  const double variance = variance_of_one(bins);
  SweepGap gap;
  double chi_squared = 0.0;
  double mean_square = 0.0;
  for (const Bin& bin : bins) {
    chi_squared += bin.mean() * bin.mean() * bin.count() / variance;
    mean_square += (bin.mean() * bin.mean() - variance / bin.count()) / static_cast<double>(bins.size());
    if (std::abs(bin.mean()) <= gap.largest) continue;
    gap.largest = std::abs(bin.mean());
    gap.at_temp_c = bin.temp_c;
    gap.noise = std::sqrt(variance / bin.count());
  }
  gap.half_sigma = 0.5 * std::sqrt(std::max(0.0, mean_square));
  gap.p_value = base::chi_squared_upper_tail(chi_squared, static_cast<double>(bins.size()));
  return gap;
}

}  // namespace soak::calib
