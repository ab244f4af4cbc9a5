// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/thermal_history.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace soak::calib::forward {
namespace {

constexpr double kReach_s = 120.0;
constexpr double kDeadBand_c = 0.5;
constexpr double kRoom_c = 23.0;

/// Sums that make the slope of a line through a moving stretch of a series.
class MovingLine {
 public:
  explicit MovingLine(double origin_s) : origin_s_(origin_s) {}

  void add(double t_s, double value, double sign) {
    const double t = t_s - origin_s_;
    count_ += sign;
    t_ += sign * t;
    v_ += sign * value;
    tt_ += sign * t * t;
    tv_ += sign * t * value;
  }
  [[nodiscard]] double slope() const {
    const double spread = tt_ - t_ * t_ / count_;
    return count_ < 3.0 || spread <= 0.0 ? 0.0 : (tv_ - t_ * v_ / count_) / spread;
  }

 private:
  double origin_s_;
  double count_ = 0.0;
  double t_ = 0.0;
  double v_ = 0.0;
  double tt_ = 0.0;
  double tv_ = 0.0;
};

/// Follows a temperature through a dead band and remembers the way it came.
class BranchMemory {
 public:
  BranchMemory(double first_c, double width_c, double memory)
      : followed_c_(first_c), width_c_(width_c), memory_(memory) {}

  double advance(double temp_c) {
    const double above = temp_c - kDeadBand_c / 2 - followed_c_;
    const double below = followed_c_ - temp_c - kDeadBand_c / 2;
    if (above > 0.0) {
      memory_ = 1.0 - (1.0 - memory_) * std::exp(-above / width_c_);
      followed_c_ += above;
    } else if (below > 0.0) {
      memory_ = (1.0 + memory_) * std::exp(-below / width_c_) - 1.0;
      followed_c_ -= below;
    }
    return memory_;
  }

 private:
  double followed_c_;
  double width_c_;
  double memory_;
};

/// 1 where the temperature first leaves the dead band upwards, or never; −1 where downwards.
double first_way(const Series& temp_c) {
  const double first_c = temp_c.values.front();
  const auto left =
      std::ranges::find_if(temp_c.values, [&](double c) { return std::abs(c - first_c) > kDeadBand_c / 2; });
  return left != temp_c.values.end() && *left < first_c ? -1.0 : 1.0;
}

}  // namespace

double Series::at(double t_s_wanted) const {
  if (t_s_wanted <= t_s.front()) return values.front();
  if (t_s_wanted >= t_s.back()) return values.back();
  const auto above = std::upper_bound(t_s.begin(), t_s.end(), t_s_wanted) - t_s.begin();
  const auto k = static_cast<std::size_t>(above);
  return std::lerp(values[k - 1], values[k], (t_s_wanted - t_s[k - 1]) / (t_s[k] - t_s[k - 1]));
}

double Series::mean(double from_s, double to_s) const {
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), from_s) - t_s.begin();
  const auto end = std::upper_bound(t_s.begin(), t_s.end(), to_s) - t_s.begin();
  if (end <= first) return at(0.5 * (from_s + to_s));
  double sum = 0.0;
  for (auto k = first; k < end; ++k) sum += values[static_cast<std::size_t>(k)];
  return sum / static_cast<double>(end - first);
}

Series series_of(const gap::RunLog& log, const std::vector<double>& channel) {
  Series series;
  for (std::size_t k = 0; k < channel.size(); ++k) {
    if (!std::isfinite(channel[k])) continue;
    series.t_s.push_back(log.t_s[k]);
    series.values.push_back(channel[k]);
  }
  return series;
}

Series rate_of(const Series& temp_c) {
  Series rate{temp_c.t_s, {}};
  if (temp_c.empty()) return rate;
  std::size_t first = 0;
  std::size_t end = 0;
  // Sums of differences from the stretch's own middle would cancel less; an origin per series is exact enough for days.
  MovingLine line(temp_c.t_s.front());
  for (const double middle_s : temp_c.t_s) {
    for (; end < temp_c.t_s.size() && temp_c.t_s[end] <= middle_s + kReach_s; ++end) {
      line.add(temp_c.t_s[end], temp_c.values[end], 1.0);
    }
    for (; temp_c.t_s[first] < middle_s - kReach_s; ++first) line.add(temp_c.t_s[first], temp_c.values[first], -1.0);
    rate.values.push_back(line.slope());
  }
  return rate;
}

Series follower_of(const Series& temp_c, double tau_s, bool under_way) {
  Series element{temp_c.t_s, {}};
  if (temp_c.empty()) return element;
  const double behind = under_way ? tau_s * rate_of(temp_c).values.front() : 0.0;
  element.values.push_back(temp_c.values.front() - behind);
  for (std::size_t k = 1; k < temp_c.t_s.size(); ++k) {
    const double dt_s = temp_c.t_s[k] - temp_c.t_s[k - 1];
    const double slope = (temp_c.values[k] - temp_c.values[k - 1]) / dt_s;
    // Behind a ramp an element settles at a distance of τ times the slope.
    const double settled = temp_c.values[k - 1] - slope * tau_s;
    const double off = element.values.back() - settled;
    element.values.push_back(settled + slope * dt_s + off * std::exp(-dt_s / tau_s));
  }
  return element;
}

Series branch_memory_of(const Series& temp_c, double width_c, std::optional<double> along) {
  Series memory{temp_c.t_s, {}};
  if (temp_c.empty()) return memory;
  const double first_c = temp_c.values.front();
  const double start = along ? *along * first_way(temp_c) : first_c < kRoom_c ? -1.0 : 1.0;
  BranchMemory branch(first_c, width_c, start);
  for (const double c : temp_c.values) memory.values.push_back(branch.advance(c));
  return memory;
}

Series water_of(const Series& temp_c, double tau_s, double activation_k) {
  constexpr double kZero_k = 273.15;
  constexpr double kFifty_k = kZero_k + 50.0;
  Series water{temp_c.t_s, {}};
  double times_tau = 0.0;  // at 50 °C that would have dried as much
  for (std::size_t k = 0; k < temp_c.t_s.size(); ++k) {
    if (k > 0) {
      const double middle_k = kZero_k + std::midpoint(temp_c.values[k - 1], temp_c.values[k]);
      const double faster = std::exp(activation_k / kFifty_k - activation_k / middle_k);
      times_tau += (temp_c.t_s[k] - temp_c.t_s[k - 1]) * faster / tau_s;
    }
    water.values.push_back(std::exp(-times_tau));
  }
  return water;
}

}  // namespace soak::calib::forward
