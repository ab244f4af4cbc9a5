// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/devices/unit_power.h"

namespace soak::station {

/// The outputs that feed the units: since when each is off, and what each said last. Times are process time. Belongs to
/// the engine's thread.
class UnitSupply {
 public:
  /// `poll_s`: between two readings of poll(). `clock_rate`: process time per host time. `power` must live longer.
  UnitSupply(hal::UnitPower& power, double poll_s, double clock_rate)
      : power_(power), poll_s_(poll_s), clock_rate_(clock_rate) {}

  /// Asks the outputs. After an error nothing is known of any.
  [[nodiscard]] base::Status read(const std::vector<int>& outputs, double now_s);
  /// The same once `poll_s` have passed since the last time (but never more often than every 2 ms of host time). True
  /// where there are new readings.
  bool poll(const std::vector<int>& outputs, double now_s);
  /// What an output said last; nothing where it did not answer.
  [[nodiscard]] std::optional<hal::OutputReading> reading(int output) const;
  /// Why the last reading failed; empty after one that did not.
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// Forgets all readings: nobody asks for a while.
  void forget();

  [[nodiscard]] base::Status switch_off(int output, double now_s);
  /// Gives the output what it shall deliver and switches it on. Refuses (internal) an output that is not known to have
  /// been off for `min_off_s`.
  [[nodiscard]] base::Status switch_on(int output, const hal::SupplySettings& settings, double min_off_s, double now_s);
  /// For how long the output is known to have been off; nothing where it is on, or was never asked. Counted by the
  /// host's clock too, and the shorter counts: the process' time may have stood still while a run was sealed.
  [[nodiscard]] std::optional<double> off_for_s(int output, double now_s) const;

  /// Why an output that was switched on does not feed its unit: it has gone off, or two readings in a row were at the
  /// current limit. Nothing where all is well or not known.
  [[nodiscard]] std::optional<std::string> trouble(int output) const;
  [[nodiscard]] bool measures(int output) const { return power_.measures(output); }
  [[nodiscard]] std::string description() const { return power_.description(); }

 private:
  struct Moment {
    double process_s;
    std::chrono::steady_clock::time_point host;
  };

  void take(int output, const hal::OutputReading& reading, double now_s);
  void note_off(int output, double now_s);

  hal::UnitPower& power_;
  double poll_s_;
  double clock_rate_;
  std::optional<double> polled_s_;
  std::chrono::steady_clock::time_point polled_host_{};
  std::string fault_;
  std::map<int, hal::OutputReading> readings_;
  std::map<int, Moment> off_since_;  ///< of the outputs that are known to be off
  std::set<int> switched_on_;        ///< by us, and not off again
  std::map<int, int> at_limit_;      ///< readings in a row
};

}  // namespace soak::station
