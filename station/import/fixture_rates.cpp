// SPDX-License-Identifier: Apache-2.0
#include "station/import/fixture_rates.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "base/units.h"
#include "station/import/slow_channel.h"

namespace soak::station {
namespace {

constexpr std::size_t kMostRates = 100;

calib::Position turning(calib::Position position, double rate_rps) {
  position.rate_dps = rate_rps * base::kDegPerRad;
  position.label = label_at_rate(position.label, *position.rate_dps);
  return position;
}

}  // namespace

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
        fmt::format("the fixture turns at more than {} rates: the column is for the rate that was asked of it, one "
                    "number for as long as it turns steadily; rows in between have no position",
                    kMostRates),
        run);
  }
  return {};
}

}  // namespace soak::station
