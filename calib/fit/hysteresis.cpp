// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/hysteresis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "calib/statistics.h"

namespace soak::calib {
namespace {

constexpr double kBin_c = 2.5;

struct Sum {
  double weight = 0.0;
  double value = 0.0;
  double temp_c = 0.0;

  void add(double w, double v, double t) {
    weight += w;
    value += w * v;
    temp_c += w * t;
  }
};

std::map<int, Sum> run_means(const CurveData& data, const std::vector<double>& residuals) {
  std::map<int, Sum> means;
  for (std::size_t i = 0; i < residuals.size(); ++i) means[data.rows[i].run].add(1.0, residuals[i], 0.0);
  return means;
}

}  // namespace

std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve) {
  std::vector<double> residuals;
  std::vector<double> errors;
  for (const CurveRow& row : data.rows) {
    residuals.push_back(row.value - evaluate(curve, row.temp_c));
    if (row.standard_error > 0.0) errors.push_back(row.standard_error);
  }
  if (errors.empty()) return std::nullopt;
  const double typical = median(errors);
  const std::map<int, Sum> offsets = run_means(data, residuals);

  std::map<long, std::pair<Sum, Sum>> bins;  // up, down
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const CurveRow& row = data.rows[i];
    if (row.sweep == Sweep::unknown) continue;
    const double se = std::max(row.standard_error, typical);
    auto& [up, down] = bins[std::lround(row.temp_c / kBin_c)];
    const Sum& offset = offsets.at(row.run);
    (row.sweep == Sweep::up ? up : down).add(1.0 / (se * se), residuals[i] - offset.value / offset.weight, row.temp_c);
  }
  SweepGap gap;
  double chi_squared = 0.0;
  std::vector<double> noise;
  for (const auto& [bin, sums] : bins) {
    const auto& [up, down] = sums;
    if (up.weight <= 0.0 || down.weight <= 0.0) continue;
    const double difference = up.value / up.weight - down.value / down.weight;
    const double variance = 1.0 / up.weight + 1.0 / down.weight;
    chi_squared += difference * difference / variance;
    noise.push_back(std::sqrt(variance));
    if (std::abs(difference) > gap.largest) {
      gap.largest = std::abs(difference);
      gap.at_temp_c = (up.temp_c + down.temp_c) / (up.weight + down.weight);
    }
  }
  if (noise.empty()) return std::nullopt;
  gap.noise = median(noise);
  gap.p_value = chi_squared_upper_tail(chi_squared, static_cast<double>(noise.size()));
  return gap;
}

}  // namespace soak::calib
