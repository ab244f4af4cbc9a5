// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/shared_terms.h"

#include <algorithm>
#include <cmath>

namespace soak::calib {
namespace {

std::optional<StatedValue> average(std::vector<Estimate> estimates) {
  std::erase_if(estimates, [](const Estimate& estimate) { return estimate.standard_error <= 0.0; });
  if (estimates.empty()) return std::nullopt;
  double weight = 0.0;
  double sum = 0.0;
  for (const Estimate& estimate : estimates) {
    const double w = std::pow(estimate.standard_error, -2);
    weight += w;
    sum += w * estimate.value;
  }
  const double mean = sum / weight;
  double scatter = 0.0;
  for (const Estimate& estimate : estimates) {
    scatter += std::pow((estimate.value - mean) / estimate.standard_error, 2);
  }
  const auto freedoms = static_cast<double>(estimates.size()) - 1.0;
  const double inflation = freedoms > 0.0 ? std::max(1.0, scatter / freedoms) : 1.0;
  StatedValue stated;
  stated.value = mean;
  stated.standard_error = std::sqrt(inflation / weight);
  return stated;
}

}  // namespace

void SharedTerms::add(const SixPositionEstimate& run) {
  for (std::size_t s = 0; s < kSensorCount; ++s) runs_[s].push_back(run.sensor[s]);
}

std::optional<Coupling> SharedTerms::coupling(bool gyros) const {
  Coupling mean;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (!gyros && i == j) continue;
      std::vector<Estimate> entries;
      for (const SensorEstimate& run : runs_[gyros ? i : i + 3]) {
        if (run.coupling[j]) entries.push_back({*run.coupling[j], run.coupling_se[j]});
      }
      const auto entry = average(entries);
      if (!entry) return std::nullopt;
      mean[i][j] = *entry;
    }
  }
  return mean;
}

std::optional<StatedValue> SharedTerms::even_order(Sensor accel) const {
  std::vector<Estimate> terms;
  for (const SensorEstimate& run : runs_[index_of(accel)]) {
    if (run.even_order) terms.push_back(*run.even_order);
  }
  return average(terms);
}

}  // namespace soak::calib
