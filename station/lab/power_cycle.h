// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/lab/lab.h"
#include "station/lab/step_task.h"

namespace soak::station {

/// Takes the supply from all units and gives it back: by the outputs of their slots, by hand where a slot has none.
class PowerCycle {
 public:
  /// `off_s`: process time that an output is off at least, whoever switched it off.
  explicit PowerCycle(double off_s) : off_s_(off_s) {}

  /// True once all have their supply, but for those of faults(). An error: the switch does not answer.
  [[nodiscard]] base::Result<bool> poll(Lab& lab);
  /// When the last one was switched on.
  [[nodiscard]] std::chrono::steady_clock::time_point on_since() const { return on_since_; }
  /// Units whose output did not stay on or stayed at its current limit, and is off again: serial number → why.
  [[nodiscard]] const std::map<std::string, std::string>& faults() const { return faults_; }

 private:
  enum class Stage : std::uint8_t { begin, by_hand, off, wait_off, on, inrush, done };

  Stage begin(Lab& lab);
  [[nodiscard]] base::Result<Stage> switch_off(Lab& lab);
  [[nodiscard]] bool was_off_long_enough(const Lab& lab) const;
  [[nodiscard]] base::Result<Stage> switch_on(Lab& lab);
  [[nodiscard]] base::Status switch_on_next(Lab& lab);
  Stage watch_inrush(Lab& lab);
  bool find_fault(Lab& lab, const UnitChannel& unit);
  [[nodiscard]] std::vector<int> measured_outputs(const Lab& lab) const;

  double off_s_;
  Stage stage_ = Stage::begin;
  std::vector<const UnitChannel*> fed_;  ///< the units with an output
  std::size_t next_ = 0;                 ///< of fed_, the next one to be switched on
  Insistence insistence_;
  std::chrono::steady_clock::time_point on_since_{};
  int looks_ = 0;  ///< at the in-rush
  std::map<std::string, std::string> faults_;
};

}  // namespace soak::station
