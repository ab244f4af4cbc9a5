// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_off.h"

#include <fmt/format.h>

#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

/// Between commands to a device that refuses them: their registers may lie in memory that wears out.
constexpr std::chrono::seconds kInterval{1};
/// One answer may be lost, or come from before the command.
constexpr int kRefusalsOfAlarm = 3;

base::Status switch_off_and_see(hal::Chamber& chamber) {
  if (auto off = chamber.stop(); !off) return off;
  const auto now = chamber.read();
  if (!now || !now->running) return {};
  return base::fail(base::ErrorKind::device, "it took the command, but still says that they are on",
                    chamber.description());
}

}  // namespace

bool ChamberOff::attempt(Station& station) {
  const auto now = steady_clock::now();
  if (now < next_) return false;
  next_ = now + kInterval;
  auto off = switch_off_and_see(station.chamber.chamber());
  if (!off) {
    note_refusal(station, std::move(off.error().message));
    return false;
  }
  if (is_alarm_) station.log.add("device", "chamber", "heating and cooling are off at last");
  forget();
  return true;
}

void ChamberOff::note_refusal(Station& station, std::string why) {
  trouble_ = std::move(why);
  if (!std::exchange(was_reported_, true)) {
    station.log.add("device", "chamber", "heating and cooling cannot be switched off: " + trouble_);
  }
  if (station.chamber.stale() || ++refusals_ < kRefusalsOfAlarm || is_alarm_) return;
  is_alarm_ = true;
  station.log.add("alarm", "chamber",
                  fmt::format("{} answers, but its heating and cooling cannot be switched off ({}): go to the chamber "
                              "and switch them off by hand. It is told again every second",
                              station.chamber.chamber().description(), trouble_));
}

void ChamberOff::forget() {
  trouble_.clear();
  refusals_ = 0;
  was_reported_ = is_alarm_ = false;
}

}  // namespace soak::station
