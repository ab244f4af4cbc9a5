// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/judge/stability.h"
#include "hal/devices/chamber.h"
#include "hal/devices/unit_power.h"

/// What the chamber and the units' supply reported last. Times are process time. They belong to the engine's thread.
namespace soak::station {

/// Reads the chamber now and then and keeps its last reading. A reading that has become stale is none. One whose air is
/// farther from the last one than any chamber gets in between (5 K and 20 K/min) does not count before a second one,
/// read at once, confirms it: until then the last one stands, with the alarms of the new one.
class ChamberMonitor {
 public:
  ChamberMonitor(hal::Chamber& chamber, double poll_s)
      : chamber_(chamber), poll_s_(poll_s), air_(calib::StabilityCriterion{}) {}

  /// Reads if `poll_s` have passed since the last time, of process time or of the host's (but never more often than
  /// every 2 ms of it). Returns true where there is a new reading.
  bool poll(double now_s);
  /// Reads at the next poll(), whenever that is; until then there is no reading.
  void forget() {
    polled_s_.reset();
    polled_host_ = {};
    reading_.reset();
    leap_c_.reset();
    alarmed_ = 0;
  }
  /// The last reading; nothing while it is older than 10 s of host time or three tries in a row have failed.
  [[nodiscard]] const std::optional<hal::ChamberReading>& reading() const { return reading_; }
  [[nodiscard]] bool stale() const { return !reading_; }
  /// Why the last try failed; empty after one that did not.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] std::optional<double> age_s() const;
  /// When the chamber was asked for the last reading.
  [[nodiscard]] std::chrono::steady_clock::time_point heard() const { return heard_host_; }
  /// The alarms of the last reading if the one before had alarms too: a single flipped bit on the wire is none. After a
  /// first one the next poll() reads at once.
  [[nodiscard]] std::vector<hal::ChamberAlarm> alarms() const;

  /// Whether the air is stable, by the criterion that was last set.
  [[nodiscard]] bool air_is_stable() const { return air_.verdict().stable; }
  void judge_air(const calib::StabilityCriterion& criterion) { air_ = calib::StabilityJudge(criterion); }

  /// The set point that the chamber was given; nothing while none is expected of it.
  void expect(const std::optional<double>& set_point_c) {
    expected_c_ = set_point_c;
    mismatches_ = 0;
  }
  [[nodiscard]] const std::optional<double>& expected_c() const { return expected_c_; }
  /// Three readings in a row show another set point, or that control is off: the controller restarted, or someone
  /// pressed its keys.
  [[nodiscard]] bool lost_set_point() const;

  [[nodiscard]] hal::Chamber& chamber() { return chamber_; }
  [[nodiscard]] const hal::Chamber& chamber() const { return chamber_; }

 private:
  /// Takes a reading, or holds one back that has leapt. True where it was taken.
  bool take(hal::ChamberReading reading, double now_s);
  void note_failure(std::string why);

  hal::Chamber& chamber_;
  double poll_s_;
  std::optional<double> polled_s_;
  std::chrono::steady_clock::time_point polled_host_{};
  std::chrono::steady_clock::time_point heard_host_{};
  std::optional<hal::ChamberReading> reading_;
  std::string trouble_;
  double reading_s_ = 0.0;        ///< process time of the reading
  std::optional<double> leap_c_;  ///< air of the reading that was held back last
  int failures_ = 0;
  int alarmed_ = 0;  ///< readings in a row with alarms
  std::optional<double> expected_c_;
  int mismatches_ = 0;
  calib::StabilityJudge air_;
};

/// Whether an output that is on delivers all that it is allowed to; never where its limit is not known.
[[nodiscard]] bool is_at_limit(const hal::OutputReading& reading);

/// The outputs that feed the units: since when each is off, and what each reported last.
class UnitSupply {
 public:
  /// `poll_s`: between two readings of poll(). `clock_rate`: process time per host time. `power` must live longer.
  UnitSupply(hal::UnitPower& power, double poll_s, double clock_rate)
      : power_(power), poll_s_(poll_s), clock_rate_(clock_rate) {}

  /// Reads the outputs. After an error nothing is known of any.
  [[nodiscard]] base::Status read(const std::vector<int>& outputs, double now_s);
  /// The same once `poll_s` have passed since the last time (but never more often than every 2 ms of host time). True
  /// where there are new readings.
  bool poll(const std::vector<int>& outputs, double now_s);
  /// What an output reported last; nothing where it did not answer.
  [[nodiscard]] std::optional<hal::OutputReading> reading(int output) const;
  [[nodiscard]] bool is_on(int output) const { return reading(output).value_or(hal::OutputReading{}).on; }
  /// Why the last reading failed; empty after one that did not.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// Forgets all readings: nobody reads for a while.
  void forget();

  [[nodiscard]] base::Status switch_off(int output, double now_s);
  /// Sets what the output shall deliver and switches it on. Refuses (internal) an output that is not known to have
  /// been off for `min_off_s`.
  [[nodiscard]] base::Status switch_on(int output, const hal::SupplySettings& settings, double min_off_s, double now_s);
  /// For how long the output is known to have been off; nothing where it is on, or was never read. Counted by the
  /// host's clock too, and the shorter counts: the process' time may have stood still while a run was sealed.
  [[nodiscard]] std::optional<double> off_for_s(int output, double now_s) const;

  /// Why an output that was switched on does not feed its unit: it has gone off, or two readings in a row were at the
  /// current limit. Nothing where all is well or not known.
  [[nodiscard]] std::optional<std::string> fault_of(int output) const;
  [[nodiscard]] bool measures(int output) const { return power_.measures(output); }
  [[nodiscard]] std::string description() const { return power_.description(); }

 private:
  struct Moment {
    double process_s;
    std::chrono::steady_clock::time_point host;
  };

  void note_off(int output, double now_s);

  hal::UnitPower& power_;
  double poll_s_;
  double clock_rate_;
  std::optional<double> polled_s_;
  std::chrono::steady_clock::time_point polled_host_{};
  std::string trouble_;
  std::map<int, hal::OutputReading> readings_;
  std::map<int, Moment> off_since_;  ///< of the outputs that are known to be off
  std::set<int> switched_on_;        ///< by us, and not off again
  std::map<int, int> at_limit_;      ///< readings in a row
};

}  // namespace soak::station
