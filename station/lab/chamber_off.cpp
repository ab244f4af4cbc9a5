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
/// Some controllers tell what they do a moment after they were told.
constexpr std::chrono::seconds kAlarmAfter{5};

}  // namespace

bool ChamberOff::attempt(Station& station) {
  const auto now = steady_clock::now();
  if (now < next_) return false;
  next_ = now + kInterval;
  auto off = switch_off_and_look(station.chamber.chamber());
  if (!off) {
    note_failure(station, std::move(off.error().message));
    return false;
  }
  if (is_alarm_) station.log.add("device", "chamber", "heating and cooling are off at last");
  forget();
  return true;
}

base::Status ChamberOff::switch_off_and_look(hal::Chamber& chamber) {
  answered_ = false;
  auto off = chamber.stop();
  answered_ = chamber.answers();
  if (!off) return off;
  const auto now = chamber.read();
  answered_ = now.has_value();
  if (now && !now->running) return {};
  if (!now && !was_seen_on_) return {};
  was_seen_on_ = true;
  return base::fail(base::ErrorKind::device,
                    now ? "it took the command, but still says that they are on"
                        : "it took the command, but cannot be read since it said that they are on",
                    chamber.description());
}

void ChamberOff::note_failure(Station& station, std::string why) {
  trouble_ = std::move(why);
  if (!std::exchange(was_reported_, true)) {
    station.log.add("device", "chamber", "heating and cooling cannot be switched off: " + trouble_);
  }
  if (!answered_ || is_alarm_) return;
  if (++refusals_ == 1) first_refusal_ = steady_clock::now();
  if (refusals_ < kRefusalsOfAlarm || steady_clock::now() - first_refusal_ < kAlarmAfter) return;
  is_alarm_ = true;
  station.log.add("alarm", "chamber",
                  fmt::format("{} answers, but its heating and cooling cannot be switched off ({}): go to the chamber "
                              "and switch them off by hand. The command is repeated every second",
                              station.chamber.chamber().description(), trouble_));
}

void ChamberOff::forget() {
  trouble_.clear();
  refusals_ = 0;
  was_reported_ = was_seen_on_ = answered_ = is_alarm_ = false;
}

}  // namespace soak::station
