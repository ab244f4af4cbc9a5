// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "station/lab/chamber_off.h"
#include "station/lab/station.h"

namespace soak::station {

/// Where a chamber is left when nobody watches it: at `wanted_c`, but at 25 °C at least, and 4 K above the dew point of
/// the room.
[[nodiscard]] double safe_temp_c(double wanted_c, double dew_point_c);

/// How patient a warm-up is with a chamber that cannot be driven, in host time.
struct WarmUpPatience {
  std::chrono::milliseconds unreadable{60'000};  ///< after which one that nobody can read is switched off
  std::chrono::milliseconds pause{60'000};       ///< before one that was given up, or did not obey, is driven again
};

/// Leaves the cold without dew: drives the chamber to at least 25 °C, waits until the air and every unit that still
/// sends its temperature are above the room's dew point, then switches heating and cooling off. Keeps trying while
/// the chamber does not answer.
///
/// A chamber that answers but does not accept the set point (a limit at its front, somebody else who commands it) must
/// not go on heating or cooling for ever: after a few tries heating and cooling are switched off, which is written to
/// the log, and the room warms the chamber instead. The set point is then sent once a minute only: controllers keep it
/// in memory that wears out. The same holds for a chamber that has not come to its set point in the time that the way
/// takes at 0.5 K/min and two hours more, and for one whose readings nobody can believe for a minute: that one is
/// driven again once it can be read.
class DewSafeWarmUp {
 public:
  explicit DewSafeWarmUp(double temp_c, const WarmUpPatience& patience = {});

  /// True once the chamber is off and no unit can gather dew.
  [[nodiscard]] bool poll(Station& station);
  /// The temperature that it drives to: above the dew point in any case.
  [[nodiscard]] double target_c(const Station& station) const;
  /// Why a chamber that answers is not on its way; empty where it is.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// Whether the chamber answers, and does not do it after some tries.
  [[nodiscard]] bool is_refused() const;
  /// Gives up the way: heating and cooling off. True once they are; to be called until then.
  [[nodiscard]] bool switch_off(Station& station);
  /// What became of the command to switch off.
  [[nodiscard]] const ChamberOff& off() const { return off_; }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool command(Station& station);
  /// Switches heating and cooling off where nothing has been read for too long, or the way has taken too long.
  void watch(Station& station);
  void give_up(Station& station, const std::string& why);
  void handle_refusal(Station& station, const std::string& why);
  [[nodiscard]] bool obeys(const Station& station);
  [[nodiscard]] bool room_has_warmed(const Station& station);
  [[nodiscard]] bool overdue(const Station& station);
  [[nodiscard]] bool units_are_dry(const Station& station) const;

  double temp_c_;
  WarmUpPatience patience_;
  bool commanded_ = false;
  int commands_ = 0;  ///< that a chamber which answers was given
  int refusals_ = 0;  ///< of them, the last ones, that it did not follow
  Clock::time_point commanded_at_{};
  std::string trouble_;
  ChamberOff off_;
  bool is_off_ = false;   ///< switched off because it does not accept the set point, or nobody can read it
  bool gave_up_ = false;  ///< the way took too long: it is not driven any more
  bool leaving_ = false;  ///< air and units were warm: all that is left is to switch off
  std::optional<Clock::time_point> read_;  ///< when there was a reading, at last
  std::optional<Clock::time_point> begun_;
  double begun_s_ = 0.0;
  double limit_s_ = 0.0;  ///< process time that the way may take
  double off_since_s_ = 0.0;
  Clock::time_point next_command_{};
  std::optional<double> warm_since_s_;
};

}  // namespace soak::station
