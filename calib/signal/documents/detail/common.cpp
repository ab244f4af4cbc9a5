// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/documents/detail/common.h"

#include <algorithm>
#include <cmath>

#include "calib/signal/allan/allan.h"
#include "calib/signal/samples/sample_grid.h"

namespace soak::calib::signal_json {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json numbers(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

json header(const SignalRecord& record) {
  const auto missing =
      std::count_if(record.values.begin(), record.values.end(), [](double v) { return std::isnan(v); });
  return {{"column", record.column},
          {"unit", record.unit},
          {"rate_hz", record.rate_hz},
          {"samples", record.values.size() - static_cast<std::size_t>(missing)},
          {"missing", missing}};
}

std::size_t longest_stretch(const std::vector<double>& values) {
  std::size_t longest = 0;
  for (const signal::SampleRange& range : signal::stretches_of(values)) longest = std::max(longest, range.count());
  return longest;
}

std::vector<double> bridged_values(const SignalRecord& record) {
  std::vector<double> values = record.values;
  signal::fill_short_gaps(values, signal::PhaseRecord::kBridge);
  return values;
}

base::Result<std::vector<double>> denoised_values(const SignalRecord& record, const WmraRequest& request) {
  const auto split = wmra(record, request);
  if (!split) return base::forward_error(split);
  std::vector<double> values = record.values;
  std::size_t next = 0;
  for (double& value : values) {
    if (!std::isnan(value)) value = split->denoised[next++];
  }
  signal::fill_short_gaps(values, signal::PhaseRecord::kBridge);
  return values;
}

}  // namespace soak::calib::signal_json
