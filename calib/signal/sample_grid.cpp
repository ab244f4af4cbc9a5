// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/sample_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace soak::calib::signal {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kGapIntervals = 1.5;
constexpr double kMostMissingPerSample = 20.0;
constexpr std::size_t kIntervalsForMedian = 10000;

/// The samples that are present, and where stretches must begin among them.
struct Present {
  std::vector<double> t_s;
  std::vector<double> values;
  std::vector<std::size_t> breaks;
};

Present present_samples(std::span<const double> t_s, std::span<const double> values,
                        std::span<const std::size_t> breaks) {
  Present present;
  present.t_s.reserve(values.size());
  present.values.reserve(values.size());
  std::size_t next_break = 0;
  bool begins = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (next_break < breaks.size() && breaks[next_break] == i) {
      begins = true;
      ++next_break;
    }
    if (std::isnan(values[i])) continue;
    if (begins) present.breaks.push_back(present.values.size());
    begins = false;
    present.t_s.push_back(t_s[i]);
    present.values.push_back(values[i]);
  }
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

/// Mean distance of neighbours that are not across a gap.
double step_of(const std::vector<double>& t_s) {
  std::vector<double> some;
  for (std::size_t i = 1; i < std::min(t_s.size(), kIntervalsForMedian); ++i) some.push_back(t_s[i] - t_s[i - 1]);
  const double longest = kGapIntervals * base::median(some);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < t_s.size(); ++i) {
    const double distance = t_s[i] - t_s[i - 1];
    if (distance > longest) continue;
    sum += distance;
    ++count;
  }
  return sum / static_cast<double>(count);
}

void append_missing(SampleGrid& grid, std::size_t count, double step_s) {
  const double from_s = grid.t_s.back();
  for (std::size_t k = 1; k <= count; ++k) {
    grid.t_s.push_back(from_s + static_cast<double>(k) * step_s);
    grid.values.push_back(kMissing);
  }
}

}  // namespace

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
  const double step_s = step_of(present.t_s);
  const double span_steps = (present.t_s.back() - present.t_s.front()) / step_s;
  if (span_steps > kMostMissingPerSample * static_cast<double>(present.values.size()) + 1e6) {
    return base::bad_input(fmt::format("{} samples over {:.0f} steps of {:g} s: the record is nearly all gaps",
                                       present.values.size(), span_steps, step_s));
  }
  SampleGrid grid;
  grid.rate_hz = 1.0 / step_s;
  std::size_t next_break = 0;
  for (std::size_t i = 0; i < present.values.size(); ++i) {
    const double distance = i == 0 ? 0.0 : present.t_s[i] - present.t_s[i - 1];
    std::size_t missing = 0;
    if (distance > kGapIntervals * step_s) missing = static_cast<std::size_t>(std::lround(distance / step_s)) - 1;
    if (next_break < present.breaks.size() && present.breaks[next_break] == i) {
      if (i > 0) missing = std::max(missing, kBreak);
      ++next_break;
    }
    if (missing > 0) append_missing(grid, missing, step_s);
    grid.t_s.push_back(present.t_s[i]);
    grid.values.push_back(present.values[i]);
  }
  return grid;
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
