// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "nav/drive/drive.h"
#include "nav/filter/alignment.h"
#include "nav/filter/navigation_filter.h"

namespace soak::nav {

/// Where a pipeline says the antenna is.
struct Solution {
  Geodetic antenna;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< east, north, up
};

/// A way from readings to positions, as a value: what runs outages knows no more of it.
struct Pipeline {
  std::string name;
  std::string description;
  /// Solutions at the times `t_s` (rising, in an outage at the end of the drive), one each. The drive holds what was
  /// known at the end of the outage: no truth, no fixes of the outage. May be called from several threads at once.
  std::function<base::Result<std::vector<Solution>>(const Drive& seen, std::span<const double> t_s)> solve;
};

/// Corrects a sample in place, as the device would; readings in the unit's own axes.
using Correction = std::function<void(ImuSample& sample)>;

/// Of a pipeline that is a filter.
struct FilterPipeline {
  std::string name;
  std::string description;
  AlignmentOptions alignment;
  FilterOptions filter;
  Correction correction = {};  ///< empty: readings as they are
  bool tune_at_rest = false;   ///< sensor models from the drive's first rest (tuning.h)
};

/// What a filter pipeline begins with: readings corrected, where it starts, what it takes for granted.
struct FilterSetup {
  Drive drive;
  Start start;
  FilterOptions options;
};
/// Fails as align() does.
[[nodiscard]] base::Result<FilterSetup> set_up(const FilterPipeline& parts, const Drive& seen);

/// Corrects the samples, aligns, runs the filter through the drive and on through the outage. Fails as align() does.
[[nodiscard]] Pipeline filter_pipeline(FilterPipeline parts);

/// What filter_pipeline() solves in each of several outages of a drive, `t_s[i]` being the times in outages[i], in one
/// way through it: where an outage begins, a copy of the filter goes on without fixes. Outages in the order in which
/// they begin. The same solutions but for rounding, at a fraction of the time. Fails as align() does; bad_input where
/// an outage begins before the filter can.
[[nodiscard]] base::Result<std::vector<std::vector<Solution>>> solve_in_passing(
    const FilterPipeline& parts, const Drive& drive, std::span<const Outage> outages,
    std::span<const std::vector<double>> t_s);

/// What is taken for granted of a MEMS unit of which nobody measured the noise, shaken by a vehicle: gyros
/// 0.05 deg/s/sqrt(Hz), a bias of 0.3 deg/s at the start that walks 0.05 deg/s in 100 s; accelerometers
/// 0.02 m/s²/sqrt(Hz), 0.3 m/s², 0.01 m/s² in 100 s; scale factors 0.5 %. No process about 0: it would draw a bias that
/// stays to 0 as fast as turns teach it.
[[nodiscard]] SensorModels typical_mems();

}  // namespace soak::nav
