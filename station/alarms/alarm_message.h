// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "station/alarms/alarm_book.h"
#include "station/alarms/delivery.h"

namespace soak::station {

/// Where and when something happened that people are told of.
struct AlarmPlace {
  std::string station;   ///< the machine's name
  std::string campaign;  ///< empty = none
  double utc_s = 0.0;
};

/// That machine, now.
[[nodiscard]] AlarmPlace place_now(std::string campaign);

/// What people are told of an alarm that has begun or ended.
[[nodiscard]] AlarmMessage message_of(const AlarmBook::Entry& entry, const AlarmPlace& place);

/// A message that somebody wrote: `title` in one line. `turn`: "test", or "note" of what is no alarm of the station.
[[nodiscard]] AlarmMessage message_of(const std::string& turn, const std::string& title, const AlarmPlace& place);

/// Text of others, such as a server's answer, as one line that a log takes.
[[nodiscard]] std::string one_line(std::string text);

}  // namespace soak::station
