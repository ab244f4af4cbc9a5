// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/stability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "base/statistics.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

constexpr double kClosest_s = 0.2;
constexpr double kMinute_s = 60.0;
constexpr double kCoarsestStep_c = 1.0;  // of a thermometer whose step is not known
constexpr double kSlack = 1.01;          // of a step, for rounding

/// Slope of a straight line through points and its standard error from the residuals.
struct Slope {
  double value;
  double standard_error;
};

Slope slope_of(std::span<const double> x, std::span<const double> y) {
  const Line line = fit_line(x, y);
  double residual = 0.0;
  double spread = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double miss = y[i] - line.mean_y - line.slope * (x[i] - line.mean_x);
    residual += miss * miss;
    spread += (x[i] - line.mean_x) * (x[i] - line.mean_x);
  }
  const double variance = residual / static_cast<double>(x.size() - 2);
  return {line.slope, std::sqrt(variance / spread)};
}

}  // namespace

StabilityJudge::StabilityJudge(const StabilityCriterion& criterion)
    : criterion_(criterion), min_window_s_(criterion.min_window_s) {}

void StabilityJudge::add(double t_s, double temp_c) {
  if (!readings_.empty() && t_s - readings_.back().t_s < kClosest_s) return;
  readings_.push_back({t_s, temp_c});
  follow_standstill(t_s, temp_c);
  while (t_s - readings_.front().t_s > criterion_.window_s) readings_.pop_front();
}

void StabilityJudge::disturb(double min_window_s) {
  readings_.clear();
  min_window_s_ = std::min(min_window_s, criterion_.window_s);
}

void StabilityJudge::follow_standstill(double t_s, double temp_c) {
  const double step = kSlack * criterion_.step_c.value_or(0.0);
  if (!still_ || t_s < still_->since_s || temp_c < still_->high_c - step || temp_c > still_->low_c + step) {
    still_ = Standstill{t_s, temp_c, temp_c};
  }
  still_->low_c = std::min(still_->low_c, temp_c);
  still_->high_c = std::max(still_->high_c, temp_c);
}

bool StabilityJudge::is_standing() const {
  if (!still_) return false;
  const double steps = still_->high_c > still_->low_c ? 2.0 : 1.0;
  const double needed_s = steps * criterion_.step_c.value_or(kCoarsestStep_c) / criterion_.slope_kpmin * kMinute_s;
  return readings_.back().t_s - still_->since_s >= needed_s;
}

double StabilityJudge::scatter_c() const {
  std::vector<double> t_s;
  std::vector<double> temp_c;
  for (const Reading& reading : readings_) {
    t_s.push_back(reading.t_s);
    temp_c.push_back(reading.temp_c);
  }
  const Line line = fit_line(t_s, temp_c);
  double sum = 0.0;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    sum += std::pow(temp_c[i] - line.mean_y - line.slope * (t_s[i] - line.mean_x), 2);
  }
  return std::sqrt(sum / static_cast<double>(t_s.size()));
}

bool StabilityJudge::is_quantised(double window_s) const {
  std::set<double> levels;
  for (const Reading& reading : readings_) {
    levels.insert(reading.temp_c);
    // More levels than a coarse step would show; also bounds the cost.
    if (levels.size() > 16) break;
  }
  double step = 0.0;
  for (auto level = levels.begin(), next = level; ++next != levels.end(); ++level) {
    step = step == 0.0 ? *next - *level : std::min(step, *next - *level);
  }
  if (criterion_.step_c) step = *criterion_.step_c;
  if (step == 0.0) return true;
  const double motion_at_limit_c = criterion_.slope_kpmin * window_s / kMinute_s;
  if (motion_at_limit_c >= 2.0 * step) return false;
  return levels.size() < 3 || scatter_c() < 0.5 * step;
}

StabilityVerdict StabilityJudge::verdict() const {
  StabilityVerdict verdict;
  if (readings_.empty()) return verdict;
  const double start_s = readings_.front().t_s;
  verdict.window_s = readings_.back().t_s - start_s;
  // A window that has just been cut to its longest is shorter than that by one reading.
  if (verdict.window_s < std::min(min_window_s_, 0.95 * criterion_.window_s)) return verdict;
  std::array<double, kBlocks> time{};
  std::array<double, kBlocks> mean{};
  std::array<double, kBlocks> count{};
  for (const Reading& reading : readings_) {
    const double share = (reading.t_s - start_s) / verdict.window_s;
    const auto block = static_cast<std::size_t>(std::min(share * kBlocks, kBlocks - 1.0));
    time[block] += reading.t_s - start_s;
    mean[block] += reading.temp_c;
    count[block] += 1.0;
  }
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (count[b] == 0.0) return verdict;
    time[b] /= count[b] * kMinute_s;
    mean[b] /= count[b];
  }
  const Slope slope = slope_of(time, mean);
  verdict.slope_kpmin = slope.value;
  verdict.half_width_kpmin = base::student_t_two_sided(criterion_.confidence, kBlocks - 2) * slope.standard_error;
  verdict.quantised = is_quantised(verdict.window_s);
  verdict.standing = is_standing();
  verdict.stable = !verdict.quantised && std::abs(slope.value) + *verdict.half_width_kpmin <= criterion_.slope_kpmin;
  return verdict;
}

}  // namespace soak::calib
