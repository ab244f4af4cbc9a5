// SPDX-License-Identifier: Apache-2.0
#include "calib/gate/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace soak::calib::gate {
namespace {

constexpr double kStretch_s = 10.0;
constexpr std::size_t kFewestStretches = 6;

}  // namespace

std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment) {
  const auto& t_s = recording.t_s;
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), segment.t_start_s);
  const auto last = std::upper_bound(first, t_s.end(), segment.t_end_s);
  return {static_cast<std::size_t>(first - t_s.begin()), static_cast<std::size_t>(last - t_s.begin())};
}

bool has(const std::vector<Finding>& findings, std::string_view code) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) { return finding.code == code; });
}

bool has(const std::vector<Finding>& findings, std::string_view code, Sensor sensor) {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.code == code && finding.sensor == sensor; });
}

std::vector<double> present(std::span<const double> values) {
  std::vector<double> result;
  std::copy_if(values.begin(), values.end(), std::back_inserter(result), [](double v) { return !std::isnan(v); });
  return result;
}

std::vector<double> times_of(std::span<const double> t_s, std::span<const double> values) {
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) result.push_back(t_s[i]);
  }
  return result;
}

double mean_of(std::span<const double> values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

std::vector<Stretch> stretches(std::span<const double> t_s) {
  const std::size_t rows = t_s.size();
  if (rows < 2 * kFewestStretches) return {};
  const double total_s = t_s.back() - t_s.front();
  const auto wanted = static_cast<std::size_t>(total_s / kStretch_s);
  const std::size_t count = std::clamp(wanted, kFewestStretches, rows / 2);
  const double row_s = total_s / static_cast<double>(rows - 1);
  std::vector<Stretch> result;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = i * rows / count;
    const std::size_t last = (i + 1) * rows / count;
    result.push_back({first, last, t_s[last - 1] - t_s[first] + row_s});
  }
  return result;
}

}  // namespace soak::calib::gate
