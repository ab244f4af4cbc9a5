// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/shared_terms.h"

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
  if (run.level_error) {
    levels_.push_back(*run.level_error);
  } else {
    no_level_.push_back(run.no_level_error);
  }
  with_headings_ = with_headings_ || run.with_headings;
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

LevelStatement SharedTerms::level() const {
  LevelStatement level;
  level.with_headings = with_headings_;
  std::vector<Estimate> north;
  std::vector<Estimate> east;
  for (const LevelError& run : levels_) {
    north.push_back(run.north);
    east.push_back(run.east);
    // The faces are the same in all runs: no mean lessens what they do.
    for (std::size_t k = 0; k < 2; ++k) {
      level.per_face_tilt[k] = std::max(level.per_face_tilt[k], run.per_face_tilt[k]);
    }
  }
  const auto to_north = average(north);
  const auto to_east = average(east);
  if (to_north && to_east) {
    level.to_north_east = {*to_north, *to_east};
  } else {
    level.reason = !no_level_.empty() ? no_level_.front()
                   : levels_.empty()  ? "no run has plateaus"
                                      : "the readings have no error that it could be judged by";
  }
  return level;
}

}  // namespace soak::calib
