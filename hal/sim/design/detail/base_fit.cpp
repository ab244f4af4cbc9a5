// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/base_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace soak::hal::sim {
namespace {

/// A column that keeps less than this of its length is a combination of those before it.
constexpr double kDependent = 1e-8;

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

template <class Value>
std::vector<double> column_of(const std::vector<PlannedBlock>& blocks, Value value) {
  std::vector<double> column;
  column.reserve(blocks.size());
  for (const PlannedBlock& block : blocks) column.push_back(value(block));
  return column;
}

}  // namespace

BaseFit::BaseFit(const std::vector<PlannedBlock>& blocks, calib::Sensor sensor, Temperature temperature) {
  int set_points = 0;
  int runs = 0;
  for (const PlannedBlock& block : blocks) {
    set_points = std::max(set_points, block.set_point + 1);
    runs = std::max(runs, block.run + 1);
  }
  const std::size_t axis = calib::axis_of(sensor);
  for (int point = 0; point < set_points; ++point) {
    const auto here = [point](const PlannedBlock& block) { return block.set_point == point ? 1.0 : 0.0; };
    if (temperature == Temperature::levels) add_column(column_of(blocks, here));
    if (calib::is_gyro(sensor)) continue;
    add_column(column_of(blocks, [&](const PlannedBlock& block) { return here(block) * block.up[axis]; }));
  }
  for (int power = 0; power < 4 && temperature == Temperature::cubic; ++power) {
    add_column(column_of(blocks, [power](const PlannedBlock& block) { return std::pow(block.temp_c / 50.0, power); }));
  }
  for (int run = 0; run < runs; ++run) {
    add_column(column_of(blocks, [run](const PlannedBlock& block) { return block.run == run ? 1.0 : 0.0; }));
  }
  for (std::size_t other = 0; other < 3 && !calib::is_gyro(sensor); ++other) {
    if (other != axis) add_column(column_of(blocks, [other](const PlannedBlock& block) { return block.up[other]; }));
  }
}

// Gram-Schmidt, twice: once leaves rounding errors along earlier columns.
void BaseFit::add_column(std::vector<double> column) {
  const double length = std::sqrt(dot(column, column));
  column = residual(residual(std::move(column)));
  const double left = std::sqrt(dot(column, column));
  if (left <= kDependent * length) return;
  for (double& value : column) value /= left;
  columns_.push_back(std::move(column));
}

std::vector<double> BaseFit::residual(std::vector<double> values) const {
  for (const std::vector<double>& column : columns_) {
    const double part = dot(column, values);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] -= part * column[i];
  }
  return values;
}

}  // namespace soak::hal::sim
