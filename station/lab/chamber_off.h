// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "station/lab/station.h"

namespace soak::station {

/// Switches heating and cooling off, and looks: a controller may take the command and go on, or refuse it. A chamber
/// that answers and does not go off in three tries and five seconds is an alarm, which names it, for people: it is told
/// again for as long as somebody calls, and nobody else is going to switch it off.
class ChamberOff {
 public:
  /// Tells the chamber, at most once a second of host time. True once its own reading says that it is off; one that
  /// cannot be read has taken the command, unless its last word was that it is on.
  [[nodiscard]] bool attempt(Station& station);
  /// What was refused does not count any more: the chamber is driven again, or was seen off.
  void forget();

  /// Why the last try failed; empty after one that did not, and where there was none.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// Whether a chamber that answered did not go off at the last try.
  [[nodiscard]] bool is_refused() const { return answered_ && !trouble_.empty(); }
  /// Whether that is an alarm.
  [[nodiscard]] bool is_alarm() const { return is_alarm_; }

 private:
  [[nodiscard]] base::Status switch_off_and_look(hal::Chamber& chamber);
  void note_failure(Station& station, std::string why);

  std::chrono::steady_clock::time_point next_{};
  std::string trouble_;
  bool answered_ = false;     ///< at the last try
  bool was_seen_on_ = false;  ///< after a command to go off
  int refusals_ = 0;          ///< of a chamber that answers
  std::chrono::steady_clock::time_point first_refusal_{};
  bool was_reported_ = false;
  bool is_alarm_ = false;
};

}  // namespace soak::station
