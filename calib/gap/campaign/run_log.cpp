// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/run_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kBin_s = 10.0;

double bin_length_s(const std::vector<double>& t_s) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t_s.size(); ++i) steps.push_back(t_s[i] - t_s[i - 1]);
  return steps.empty() ? kBin_s : std::max(kBin_s, base::median(steps));
}

/// First row of each bin, and one past the last row.
std::vector<std::size_t> bin_edges(const std::vector<double>& t_s, double length_s) {
  std::vector<std::size_t> edges;
  double bin = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const double here = std::floor((t_s[i] - t_s.front()) / length_s);
    if (here > bin) edges.push_back(i);
    bin = here;
  }
  edges.push_back(t_s.size());
  return edges;
}

std::vector<double> means(const std::vector<double>& values, const std::vector<std::size_t>& edges) {
  std::vector<double> result;
  if (values.empty()) return result;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = edges[k]; i < edges[k + 1]; ++i) {
      if (!std::isfinite(values[i])) continue;
      sum += values[i];
      count += 1.0;
    }
    result.push_back(count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

std::vector<double> auxiliary(const Recording& recording, std::string_view name,
                              const std::vector<std::size_t>& edges) {
  for (const AuxiliaryChannel& channel : recording.auxiliary) {
    if (channel.name == name) return means(channel.values, edges);
  }
  return {};
}

}  // namespace

RunLog make_run_log(const Recording& recording) {
  RunLog log;
  if (recording.t_s.empty()) return log;
  const auto edges = bin_edges(recording.t_s, bin_length_s(recording.t_s));
  log.t_s = means(recording.t_s, edges);
  log.temp_c = means(recording.temp_c, edges);
  log.t_since_power_s = means(recording.t_since_power_s, edges);
  if (log.t_since_power_s.empty()) {
    for (const double t_s : log.t_s) log.t_since_power_s.push_back(t_s - recording.t_s.front());
  }
  log.chamber_c = auxiliary(recording, "chamber_c", edges);
  log.compressor = auxiliary(recording, "compressor", edges);
  log.supply_v = auxiliary(recording, "supply_v", edges);
  return log;
}

}  // namespace soak::calib::gap
