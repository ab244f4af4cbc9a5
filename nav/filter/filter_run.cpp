// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/filter_run.h"

#include <algorithm>

namespace soak::nav {

FilterRun::FilterRun(const Drive& drive, const Start& start, const FilterOptions& options)
    : drive_(drive),
      options_(options),
      filter_(start, options, drive.lever_arm_m),
      feed_(drive.imu, start.t_s),
      next_constraint_s_(start.t_s) {
  const auto next = std::ranges::upper_bound(drive.gnss, start.t_s, {}, &GnssFix::t_s);
  next_fix_ = static_cast<std::size_t>(next - drive.gnss.begin());
}

FilterRun::FilterRun(const FilterRun& so_far, const Drive& drive)
    : drive_(drive),
      options_(so_far.options_),
      filter_(so_far.filter_),
      feed_(so_far.feed_, drive.imu),
      next_fix_(so_far.next_fix_),
      next_constraint_s_(so_far.next_constraint_s_) {}

void FilterRun::watch_standstill(const ImuSample& sample) {
  if (!window_.empty() && window_.back().t_s == sample.t_s) return;
  window_.push_back(sample);
  if (sample.t_s - window_.front().t_s < options_.standstill->window_s) return;
  if (stands(window_, *options_.standstill)) filter_.update_standstill(options_.standstill->velocity_sigma_mps);
  window_.clear();
}

void FilterRun::predict_to(double t_s) {
  while (const auto piece = feed_.next(t_s)) {
    if (before_prediction) before_prediction(filter_);
    filter_.predict(piece->sample->rate_rps, piece->sample->force_mps2, piece->duration_s);
    if (after_prediction) after_prediction(filter_);
    if (options_.standstill) watch_standstill(*piece->sample);
    if (!options_.non_holonomic || feed_.now_s() < next_constraint_s_) continue;
    filter_.update_non_holonomic(options_.non_holonomic->sigma_mps);
    next_constraint_s_ = feed_.now_s() + options_.non_holonomic->interval_s;
  }
}

void FilterRun::advance_to(double t_s) {
  for (; next_fix_ < drive_.gnss.size() && drive_.gnss[next_fix_].t_s <= t_s; ++next_fix_) {
    const GnssFix& fix = drive_.gnss[next_fix_];
    predict_to(fix.t_s);
    if (feed_.now_s() + 1e-6 < fix.t_s) return;
    const Innovation position = filter_.update_position(fix);
    const Innovation velocity = filter_.update_velocity(fix);
    if (on_fix) on_fix(fix, position, velocity);
  }
  predict_to(t_s);
}

}  // namespace soak::nav
