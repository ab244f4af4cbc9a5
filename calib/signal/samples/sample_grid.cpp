// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/samples/sample_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace soak::calib::signal {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kMostMissingPerSample = 20.0;
constexpr double kLongestDistance = 10.0;  ///< in median distances, that the step is learnt from
constexpr double kRateChange = 0.1;
constexpr std::size_t kWindow = 20;           ///< distances together
constexpr double kSteadyWindows = 1.5;        ///< 90 % point over 10 % point of the windows' means
constexpr double kFollow = 0.05;              ///< share of a sample's distance from the clock that the clock takes over
constexpr std::size_t kFewestForHalves = 80;  ///< distances in each half, to judge a change of rate

/// The samples that are present, and where stretches must begin among them.
struct Present {
  std::span<const double> t_s;
  std::span<const double> values;
  std::vector<std::size_t> breaks;
  std::vector<double> own_t_s;  ///< only where samples are missing: records are large
  std::vector<double> own_values;
};

Present present_samples(std::span<const double> t_s, std::span<const double> values,
                        std::span<const std::size_t> breaks) {
  if (std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) {
    return {t_s, values, {breaks.begin(), breaks.end()}, {}, {}};
  }
  Present present;
  present.own_t_s.reserve(values.size());
  present.own_values.reserve(values.size());
  std::size_t next_break = 0;
  bool begins = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (next_break < breaks.size() && breaks[next_break] == i) {
      begins = true;
      ++next_break;
    }
    if (std::isnan(values[i])) continue;
    if (begins) present.breaks.push_back(present.own_values.size());
    begins = false;
    present.own_t_s.push_back(t_s[i]);
    present.own_values.push_back(values[i]);
  }
  present.t_s = present.own_t_s;
  present.values = present.own_values;
  return present;
}

base::Status check_rising(std::span<const double> t_s) {
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    if (!std::isfinite(t_s[i]) || (i > 0 && !(t_s[i] > t_s[i - 1]))) {
      return base::bad_input(
          fmt::format("the time does not rise at sample {} ({} s): samples need rising times", i, t_s[i]));
    }
  }
  return {};
}

std::vector<double> distances_of(std::span<const double> t_s) {
  std::vector<double> distances;
  distances.reserve(t_s.size());
  for (std::size_t i = 1; i < t_s.size(); ++i) distances.push_back(t_s[i] - t_s[i - 1]);
  return distances;
}

/// Mean of the distances that are not longer than `longest`.
double mean_up_to(std::span<const double> distances, double longest) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const double d : distances) {
    if (d > longest) continue;
    sum += d;
    ++count;
  }
  return sum / static_cast<double>(count);
}

/// Even steps, and how late a sample may be before another one must have been lost.
struct Steps {
  double step_s = 0.0;
  double slack = 0.75;  ///< in steps; more than a half, since lateness that is not jitter adds up until it shows
};

/// A clock of even steps that follows the times of samples slowly.
class Clock {
 public:
  Clock(double start_s, const Steps& steps) : now_s_(start_s), steps_(steps) {}

  /// Whole steps from the last sample to this one, one at least.
  std::size_t steps_to(double t_s) {
    const double late = (t_s - now_s_) / steps_.step_s;
    const double steps = late < 1.0 + steps_.slack ? 1.0 : std::round(late);
    now_s_ += steps * steps_.step_s;
    const double off_s = t_s - now_s_;
    now_s_ += steps > kLongestDistance ? off_s : kFollow * off_s;
    squares_ += (off_s / steps_.step_s) * (off_s / steps_.step_s);
    ++count_;
    return static_cast<std::size_t>(steps);
  }

  [[nodiscard]] double scatter() const { return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0.0; }

 private:
  double now_s_;
  Steps steps_;
  double squares_ = 0.0;
  std::size_t count_ = 0;
};

/// One pass: sum of distances / sum of the whole numbers of steps that `whole_steps` makes of them.
template <class WholeSteps>
double step_by(std::span<const double> distances, WholeSteps whole_steps) {
  double sum = 0.0;
  double steps = 0.0;
  for (const double d : distances) {
    const double whole = whole_steps(d);
    if (whole > kLongestDistance) continue;
    sum += d;
    steps += whole;
  }
  return sum / steps;
}

/// From the median: distance by distance first (a median of times that were printed coarsely is off by too much for the
/// clock), then by the clock (which jitter does not mislead).
double refined_step(std::span<const double> distances) {
  double step = base::median(distances);
  for (int pass = 0; pass < 5; ++pass) step = step_by(distances, [&](double d) { return std::round(d / step); });
  for (int pass = 0; pass < 3; ++pass) {
    Clock clock(0.0, {step});
    double t_s = 0.0;
    step = step_by(distances, [&](double d) { return static_cast<double>(clock.steps_to(t_s += d)); });
  }
  return step;
}

/// Means of twenty distances in a row.
std::vector<double> window_means(std::span<const double> distances) {
  std::vector<double> means;
  for (std::size_t first = 0; first + kWindow <= distances.size(); first += kWindow) {
    double sum = 0.0;
    for (const double d : distances.subspan(first, kWindow)) sum += d;
    means.push_back(sum / kWindow);
  }
  std::sort(means.begin(), means.end());
  return means;
}

bool come_in_bursts(const std::vector<double>& sorted_means, double step) {
  if (sorted_means.empty()) return false;
  const auto at = [&](double share) {
    return sorted_means[static_cast<std::size_t>(share * static_cast<double>(sorted_means.size() - 1))];
  };
  return at(0.5) > 2.0 * step && at(0.9) < kSteadyWindows * at(0.1);
}

Steps steps_of(std::span<const double> distances) {
  const double step = refined_step(distances);
  const std::vector<double> means = window_means(distances);
  if (!come_in_bursts(means, step)) return {step};
  std::vector<double> sorted(distances.begin(), distances.end());
  const auto usual = sorted.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), usual, sorted.end());
  const double mean = mean_up_to(distances, kLongestDistance * means[means.size() / 2]);
  return {mean, 2.0 * *usual / mean};
}

base::Status check_steady(std::span<const double> distances) {
  const std::size_t half = distances.size() / 2;
  if (half < kFewestForHalves) return {};
  const auto change = [](double a, double b) { return std::abs(a / b - 1.0) > kRateChange; };
  const double before = steps_of(distances.first(half)).step_s;
  const double after = steps_of(distances.last(half)).step_s;
  const bool medians_differ = change(base::median(distances.first(half)), base::median(distances.last(half)));
  if (!change(before, after) || !medians_differ) return {};
  return base::bad_input(
      fmt::format("the rate changes from {:g} to {:g} Hz between the halves: analyse each part by itself", 1.0 / before,
                  1.0 / after));
}

base::Result<Steps> steps_between(std::span<const double> t_s) {
  const std::vector<double> distances = distances_of(t_s);
  if (auto status = check_steady(distances); !status) return base::forward_error(status);
  return steps_of(distances);
}

void append_missing(SampleGrid& grid, std::size_t count, double step_s) {
  const double from_s = grid.t_s.back();
  for (std::size_t k = 1; k <= count; ++k) {
    grid.t_s.push_back(from_s + static_cast<double>(k) * step_s);
    grid.values.push_back(kMissing);
  }
}

SampleGrid placed(const Present& present, const Steps& steps) {
  SampleGrid grid;
  grid.rate_hz = 1.0 / steps.step_s;
  grid.t_s.reserve(present.values.size());
  grid.values.reserve(present.values.size());
  Clock clock(present.t_s.front(), steps);
  std::size_t next_break = 0;
  for (std::size_t i = 0; i < present.values.size(); ++i) {
    std::size_t missing = i == 0 ? 0 : clock.steps_to(present.t_s[i]) - 1;
    if (next_break < present.breaks.size() && present.breaks[next_break] == i) {
      if (i > 0) missing = std::max(missing, kBreak);
      ++next_break;
    }
    if (missing > 0) append_missing(grid, missing, steps.step_s);
    grid.t_s.push_back(present.t_s[i]);
    grid.values.push_back(present.values[i]);
  }
  grid.scatter = clock.scatter();
  return grid;
}

}  // namespace

base::Status check_rate(double rate_hz) {
  if (std::isfinite(rate_hz) && rate_hz > 0.0) return {};
  return base::bad_input(fmt::format("the sampling rate is {} Hz: it must be finite and above 0", rate_hz), "rate_hz");
}

base::Status check_none_infinite(std::span<const double> samples, std::size_t first) {
  const auto infinite = std::ranges::find_if(samples, [](double v) { return std::isinf(v); });
  if (infinite == samples.end()) return {};
  return base::bad_input("the sample is infinite: values must be finite, or NaN where one is missing",
                         fmt::format("sample {}", first + static_cast<std::size_t>(infinite - samples.begin())));
}

base::Result<SampleGrid> equally_spaced(std::span<const double> t_s, std::span<const double> values,
                                        std::span<const std::size_t> breaks) {
  if (t_s.size() != values.size()) {
    return base::bad_input(fmt::format("{} times for {} values: there must be one each", t_s.size(), values.size()));
  }
  const Present present = present_samples(t_s, values, breaks);
  if (present.values.size() < 2) {
    return base::bad_input(fmt::format("{} samples: at least 2 are needed", present.values.size()));
  }
  if (auto status = check_rising(present.t_s); !status) return base::forward_error(status);
  const auto checked_steps = steps_between(present.t_s);
  if (!checked_steps) return base::forward_error(checked_steps);
  const Steps& steps = *checked_steps;
  const double span_steps = (present.t_s.back() - present.t_s.front()) / steps.step_s;
  if (span_steps > kMostMissingPerSample * static_cast<double>(present.values.size()) + 1e6) {
    return base::bad_input(fmt::format("{} samples over {:.0f} steps of {:g} s: the record is nearly all gaps",
                                       present.values.size(), span_steps, steps.step_s));
  }
  return placed(present, steps);
}

std::vector<SampleRange> stretches_of(std::span<const double> values) {
  std::vector<SampleRange> ranges;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (ranges.empty() || ranges.back().last != i) ranges.push_back({i, i});
    ranges.back().last = i + 1;
  }
  return ranges;
}

std::size_t fill_short_gaps(std::span<double> values, std::size_t longest) {
  const std::vector<SampleRange> ranges = stretches_of(values);
  std::size_t filled = 0;
  for (std::size_t r = 1; r < ranges.size(); ++r) {
    const std::size_t before = ranges[r - 1].last - 1;
    const std::size_t after = ranges[r].first;
    if (after - before - 1 > longest) continue;
    const double slope = (values[after] - values[before]) / static_cast<double>(after - before);
    for (std::size_t i = before + 1; i < after; ++i, ++filled) {
      values[i] = values[before] + slope * static_cast<double>(i - before);
    }
  }
  return filled;
}

void remove_stretch_means(std::span<double> values) {
  for (const SampleRange& range : stretches_of(values)) {
    const std::span<double> stretch = values.subspan(range.first, range.count());
    double sum = 0.0;
    for (const double v : stretch) sum += v - stretch.front();
    const double mean = stretch.front() + sum / static_cast<double>(stretch.size());
    for (double& v : stretch) v -= mean;
  }
}

}  // namespace soak::calib::signal
