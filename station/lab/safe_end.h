// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "station/lab/dew_safe_warm_up.h"
#include "station/lab/station.h"
#include "station/lab/steps.h"

namespace soak::station {

/// The way to the safe state when a campaign is cut short. A broken device does not keep the others from being made
/// safe. Chamber warm and off (at once off where an alarm asks for it), fixture halted, run file sealed, units off, and
/// still off a second later. The chamber is commanded first.
class SafeEnd {
 public:
  /// `outputs_off`: heating and cooling must stop at once. `aborted`: somebody has ended the campaign.
  SafeEnd(std::string reason, double end_c, bool outputs_off, bool aborted);

  /// True once everything that answers is safe. Goes on for as long as the chamber does not answer, or does not go off;
  /// a supply of the units has half a minute after that.
  [[nodiscard]] bool poll(Station& station);
  /// What it is doing, for the operator.
  [[nodiscard]] std::string text(const Station& station) const;
  /// Whether a person has to go to the chamber: it does not answer, or does not do what it is told.
  [[nodiscard]] bool needs_somebody(const Station& station) const;
  /// Why who only waits for the chamber need not wait any more: it has not answered, or has refused to go off, for two
  /// hours of process time, as the way to the safe state may take beyond its own length, and a minute of host time.
  /// Empty as long as there is hope.
  [[nodiscard]] std::string why_hopeless(const Station& station) const;
  /// One last try to switch the units off, where soakd ends before the chamber is safe. What is wrong with that; empty
  /// where they are off, or nothing switches them.
  [[nodiscard]] std::string leave_units(Station& station);
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
  /// Beside this thread: the chamber and the units do not wait for it.
  void seal_run(Station& station);
  [[nodiscard]] bool units_are_off(Station& station);
  [[nodiscard]] bool units_stay_off(Station& station);

  std::string reason_;
  bool outputs_off_;
  bool aborted_;
  std::string trouble_;
  DewSafeWarmUp warm_up_;
  /// When the chamber answered last and had not refused to go off, or poll() began.
  std::optional<std::chrono::steady_clock::time_point> obeyed_;
  double obeyed_s_ = 0.0;  ///< the same in process time
  bool chamber_is_safe_ = false;
  bool run_is_sealed_ = false;
  bool units_are_off_ = false;
  CommandRetry units_off_;
  int looks_ = 0;  ///< at the units' outputs that are left, once these were switched off
  std::chrono::steady_clock::time_point next_look_{};
  bool fixture_is_halted_ = false;
  bool fixture_was_reported_ = false;
  std::chrono::steady_clock::time_point next_halt_{};
};

}  // namespace soak::station
