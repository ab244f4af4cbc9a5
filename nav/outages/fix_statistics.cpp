// SPDX-License-Identifier: Apache-2.0
#include "nav/outages/fix_statistics.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "base/statistics.h"
#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

FixStatistics statistics_of(const std::vector<Innovation>& innovations) {
  if (innovations.empty()) return {std::numeric_limits<double>::quiet_NaN(), 0};
  std::vector<double> nis;
  for (const Innovation& innovation : innovations) nis.push_back(innovation.nis);
  const auto left_out = std::ranges::count(innovations, false, &Innovation::used);
  return {base::median(nis), static_cast<std::size_t>(left_out)};
}

}  // namespace

base::Result<Innovations> innovations_of(const Drive& drive, const FilterPipeline& filter) {
  const auto setup = set_up(filter, drive);
  if (!setup) return base::forward_error(setup);
  std::vector<Innovation> positions;
  std::vector<Innovation> velocities;
  FilterRun run(setup->drive, setup->start, setup->options);
  run.on_fix = [&](const GnssFix&, const Innovation& position, const Innovation& velocity) {
    positions.push_back(position);
    velocities.push_back(velocity);
  };
  run.advance_to(drive.imu.back().t_s);
  return Innovations{positions.size(), statistics_of(positions), statistics_of(velocities)};
}

}  // namespace soak::nav
