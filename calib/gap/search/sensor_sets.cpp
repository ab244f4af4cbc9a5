// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/sensor_sets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace soak::calib::gap {

std::vector<std::vector<Sensor>> sensor_sets(const std::vector<Sensor>& sensors) {
  std::vector<std::vector<Sensor>> sets(3);
  for (const Sensor sensor : sensors) {
    sets[0].push_back(sensor);
    sets[is_gyro(sensor) ? 1 : 2].push_back(sensor);
    sets.push_back({sensor});
  }
  std::sort(sets.begin(), sets.end());
  sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  return sets;
}

double chance_together(std::span<const double> chances) {
  if (chances.empty()) return 1.0;
  double squares = 0.0;
  for (const double p : chances) squares -= 2.0 * std::log(std::max(p, std::numeric_limits<double>::min()));
  return base::chi_squared_upper_tail(squares, 2.0 * static_cast<double>(chances.size()));
}

}  // namespace soak::calib::gap
