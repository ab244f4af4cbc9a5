// SPDX-License-Identifier: Apache-2.0
#include "station/import/slow_channel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/units.h"

namespace soak::station {
namespace {

constexpr double kHold_s = 2.0;  // a value holds so long at least

constexpr std::size_t kMostRates = 100;

calib::Position turning(calib::Position position, double rate_rps) {
  position.rate_dps = rate_rps * base::kDegPerRad;
  position.label = label_at_rate(position.label, *position.rate_dps);
  return position;
}

}  // namespace

void HoldLimit::add(std::span<const double> t_s, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (last_s_) {
      ++distances_;
      if (!(1.5 * (t_s[i] - *last_s_) <= kHold_s)) long_s_.push_back(t_s[i] - *last_s_);
    }
    last_s_ = t_s[i];
  }
}

/// kHold_s, or 1.5 times the median distance in time between neighbouring values that are present where that is longer.
double HoldLimit::limit_s() const {
  // The median of all, if it is among the long ones: those are the last in order.
  const std::size_t middle = distances_ / 2;
  const std::size_t others = distances_ - long_s_.size();
  if (distances_ == 0 || middle < others) return kHold_s;
  std::vector<double> sorted = long_s_;
  const auto median = sorted.begin() + static_cast<std::ptrdiff_t>(middle - others);
  std::nth_element(sorted.begin(), median, sorted.end());
  return std::max(kHold_s, 1.5 * *median);
}

void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values) {
  if (std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) return;
  HoldLimit limit;
  limit.add(t_s, values);
  hold_slow_channel(t_s, values, limit.limit_s());
}

void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values, double limit_s) {
  double last = std::numeric_limits<double>::quiet_NaN();
  double last_t_s = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) {
      last = values[i];
      last_t_s = t_s[i];
    } else if (t_s[i] - last_t_s <= limit_s) {
      values[i] = last;
    }
  }
}

std::string label_at_rate(const std::string& label, double rate_dps) {
  return fmt::format("{} at {:.6g} deg/s", label, rate_dps);
}

bool is_fixture_rate(const db::ChannelInfo& channel) { return channel.name == "rate_dps" && !channel.unit.empty(); }

base::Status split_by_rate(calib::Recording& recording, std::vector<double> rate_rps, const std::string& run) {
  if (rate_rps.empty() || recording.position.empty()) return {};
  hold_slow_channel(recording.t_s, rate_rps);
  std::map<std::pair<std::int32_t, double>, std::int32_t> known;
  for (std::size_t i = 0; i < rate_rps.size(); ++i) {
    std::int32_t& position = recording.position[i];
    if (std::isnan(rate_rps[i])) position = -1;
    if (position < 0 || rate_rps[i] == 0.0) continue;
    const auto next = static_cast<std::int32_t>(recording.positions.size());
    const auto [entry, is_new] = known.try_emplace({position, rate_rps[i]}, next);
    if (is_new) {
      recording.positions.push_back(turning(recording.positions[static_cast<std::size_t>(position)], rate_rps[i]));
    }
    position = entry->second;
    if (known.size() <= kMostRates) continue;
    return base::bad_input(
        fmt::format("the fixture turns at more than {} rates: the column must give the commanded rate, one number for "
                    "as long as the fixture turns steadily; leave it empty in between",
                    kMostRates),
        run);
  }
  return {};
}

}  // namespace soak::station
