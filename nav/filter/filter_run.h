// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "base/result.h"
#include "nav/drive/drive.h"
#include "nav/filter/navigation_filter.h"

namespace soak::nav {

/// A filter on its way through a drive: readings and fixes in the order of time, with the updates that the options ask
/// for. What happens between two samples cuts the interval.
class FilterRun {
 public:
  /// The drive must outlive it. Fixes up to the start are passed over.
  FilterRun(const Drive& drive, const Start& start, const FilterOptions& options);

  /// Goes on where the other one is, on a drive of the same times and fixes with other readings.
  FilterRun(const FilterRun& so_far, const Drive& drive);

  /// From now on there are no fixes: what the filter would do in an outage, on a copy of the run.
  void lose_fixes() { next_fix_ = drive_.gnss.size(); }

  /// Carries the filter to `t_s`, or to the last sample.
  void advance_to(double t_s);

  [[nodiscard]] double now_s() const { return feed_.now_s(); }
  [[nodiscard]] const NavigationFilter& filter() const { return filter_; }
  /// For updates from elsewhere.
  [[nodiscard]] NavigationFilter& filter() { return filter_; }

  /// Called after each fix with what became of its position and of its velocity.
  std::function<void(const GnssFix&, const Innovation& position, const Innovation& velocity)> on_fix;
  /// Called before and after the filter is carried on by a sample or a part of one.
  std::function<void(const NavigationFilter&)> before_prediction;
  std::function<void(const NavigationFilter&)> after_prediction;

 private:
  void predict_to(double t_s);
  void watch_standstill(const ImuSample& sample);

  const Drive& drive_;
  FilterOptions options_;
  NavigationFilter filter_;
  ImuFeed feed_;
  std::size_t next_fix_ = 0;
  double next_constraint_s_;
  std::vector<ImuSample> window_;  ///< the last samples, for the search of standstill
};

}  // namespace soak::nav
