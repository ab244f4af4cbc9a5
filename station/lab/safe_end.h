// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "station/lab/station.h"
#include "station/lab/steps.h"

namespace soak::station {

/// Where a chamber is left when nobody watches it: at `wanted_c`, but at 25 °C at least, and 4 K above the dew point of
/// the room.
[[nodiscard]] double safe_temp_c(double wanted_c, double dew_point_c);

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
  explicit DewSafeWarmUp(double temp_c);

  /// True once the chamber is off and no unit can gather dew.
  [[nodiscard]] bool poll(Station& station);
  /// The temperature that it drives to: above the dew point in any case.
  [[nodiscard]] double target_c(const Station& station) const;
  /// Why a chamber that answers is not on its way; empty where it is.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// Whether the chamber answers, and does not do it after some tries.
  [[nodiscard]] bool is_refused() const;

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
  [[nodiscard]] bool switch_off(Station& station);
  [[nodiscard]] bool units_are_dry(const Station& station) const;

  double temp_c_;
  bool commanded_ = false;
  int commands_ = 0;  ///< that a chamber which answers was given
  int refusals_ = 0;  ///< of them, the last ones, that it did not follow
  Clock::time_point commanded_at_{};
  std::string trouble_;
  bool is_off_ = false;   ///< switched off because it does not accept the set point, or nobody can read it
  bool gave_up_ = false;  ///< the way took too long: it is not driven any more
  std::optional<Clock::time_point> read_;  ///< when there was a reading, at last
  std::optional<Clock::time_point> begun_;
  double begun_s_ = 0.0;
  double limit_s_ = 0.0;  ///< process time that the way may take
  double off_since_s_ = 0.0;
  Clock::time_point next_command_{};
  Clock::time_point next_stop_{};
  std::optional<double> warm_since_s_;
};

/// The way to the safe state when a campaign is cut short. A broken device does not keep the others from being made
/// safe. Chamber warm and off (at once off where an alarm asks for it), fixture halted, run file sealed, units off. The
/// chamber is commanded first.
class SafeEnd {
 public:
  /// `outputs_off`: heating and cooling must stop at once. `aborted`: somebody has ended the campaign.
  SafeEnd(std::string reason, double end_c, bool outputs_off, bool aborted);

  /// True once everything that answers is safe. Goes on for as long as the chamber does not answer; a supply of the
  /// units has half a minute after that.
  [[nodiscard]] bool poll(Station& station);
  /// What it is doing, for the operator.
  [[nodiscard]] std::string text(const Station& station) const;
  /// Whether a person has to go to the chamber: it does not answer, or does not do what it is told.
  [[nodiscard]] bool needs_somebody(const Station& station) const;
  /// Whether the chamber has not answered for so long that who only waits for it need not wait any more: for two hours
  /// of process time, as the way to the safe state may take beyond its own length, and a minute of host time.
  [[nodiscard]] bool is_silent_for_good(const Station& station) const;
  /// Heating and cooling must not go on, for this reason.
  void switch_off_at_once(Station& station, const std::string& why);
  /// Somebody has ended the campaign that was to be interrupted only.
  void note_abort(const std::string& reason);
  /// What has gone wrong on the way that only a person should decide upon: an alarm, a trip, a chamber that refuses.
  /// Empty where nothing has.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] bool outputs_off() const { return outputs_off_; }

 private:
  void halt_fixture(Station& station);
  [[nodiscard]] bool switch_chamber_off(Station& station);
  /// Beside this thread: the chamber and the units do not wait for it.
  void seal_run(Station& station);
  [[nodiscard]] bool units_are_off(Station& station);

  std::string reason_;
  bool outputs_off_;
  bool aborted_;
  std::string trouble_;
  DewSafeWarmUp warm_up_;
  std::optional<std::chrono::steady_clock::time_point> heard_;  ///< when the chamber answered last, or poll() began
  double heard_s_ = 0.0;                                        ///< the same in process time
  bool chamber_is_safe_ = false;
  bool run_is_sealed_ = false;
  bool units_are_off_ = false;
  CommandRetry units_off_;
  bool fixture_is_halted_ = false;
  bool fixture_was_reported_ = false;
  bool chamber_was_reported_ = false;
  std::chrono::steady_clock::time_point next_halt_{};
  std::chrono::steady_clock::time_point next_stop_{};
};

}  // namespace soak::station
