// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "station/lab/lab.h"
#include "station/lab/step_task.h"
#include "station/lab/warmth.h"

namespace soak::station {

/// The way to the safe state when a campaign is cut short: whatever is broken does not keep the rest from being made
/// safe. Fixture halted, chamber warm and off (at once off where an alarm asks for it), run file sealed and voided,
/// units off.
class SafeEnd {
 public:
  /// `outputs_off`: heating and cooling must not run a moment longer.
  SafeEnd(std::string reason, double end_c, bool outputs_off);

  /// True once everything that answers is safe. Goes on for as long as the chamber does not answer; a supply of the
  /// units has half a minute after that.
  [[nodiscard]] bool poll(Lab& lab);
  [[nodiscard]] const std::string& reason() const { return reason_; }
  /// What it is doing, for the operator.
  [[nodiscard]] std::string text(const Lab& lab) const;

 private:
  void halt_fixture(Lab& lab);
  [[nodiscard]] bool make_chamber_safe(Lab& lab);
  [[nodiscard]] bool switch_chamber_off(Lab& lab);
  void seal_run(Lab& lab);
  [[nodiscard]] bool units_are_off(Lab& lab);

  std::string reason_;
  bool outputs_off_;
  Warmth warmth_;
  bool chamber_is_safe_ = false;
  bool run_is_sealed_ = false;
  Insistence units_off_;
  bool fixture_rests_ = false;
  bool fixture_is_blamed_ = false;
  bool chamber_is_blamed_ = false;
  std::chrono::steady_clock::time_point next_halt_{};
  std::chrono::steady_clock::time_point next_stop_{};
};

}  // namespace soak::station
