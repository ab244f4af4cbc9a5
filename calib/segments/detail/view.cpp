// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/segments/detail/scan.h"

namespace soak::calib::gate {

Present::Present(std::span<const double> t_s, std::span<const double> values, bool complete)
    : values_(values), t_s_(t_s) {
  // One NaN makes the sum NaN; infinities may too, and then there is nothing to leave out.
  if (complete || !std::isnan(deviation_from(values, 0.0).sum)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    own_values_.push_back(values[i]);
    own_t_s_.push_back(t_s[i]);
  }
  complete_ = own_values_.size() == values.size();
  values_ = own_values_;
  t_s_ = own_t_s_;
}

std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment) {
  const auto& t_s = recording.t_s;
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), segment.t_start_s);
  const auto last = std::upper_bound(first, t_s.end(), segment.t_end_s);
  return {static_cast<std::size_t>(first - t_s.begin()), static_cast<std::size_t>(last - t_s.begin())};
}

bool rejected_as(const std::vector<Finding>& findings, std::string_view code) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
    return finding.code == code && finding.severity == Severity::reject;
  });
}

double mean_of(std::span<const double> values) {
  const double sum_of_all = deviation_from(values, 0.0).sum;
  if (!std::isnan(sum_of_all) && !values.empty()) return sum_of_all / static_cast<double>(values.size());
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double step_of(const View& view, Sensor sensor) {
  const double stated = is_gyro(sensor) ? view.type.gyro_lsb_dps.value_or(0.0) / printed_per_si(sensor)
                                        : view.type.accel_lsb_mps2.value_or(0.0);
  return std::max(stated, view.facts_of(sensor).step);
}

}  // namespace soak::calib::gate
