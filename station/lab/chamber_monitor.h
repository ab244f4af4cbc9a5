// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/judge/stability.h"
#include "hal/devices/chamber.h"

namespace soak::station {

/// Reads the chamber now and then and keeps what it said last. A value that has become stale is no value.
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
  }
  /// The last reading; nothing while it is older than 10 s of host time or three tries in a row have failed.
  [[nodiscard]] const std::optional<hal::ChamberReading>& reading() const { return reading_; }
  [[nodiscard]] bool stale() const { return !reading_; }
  /// Why the last try failed; empty after one that did not.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] std::optional<double> age_s() const;

  /// Whether the air stands still, by the criterion that was last set.
  [[nodiscard]] bool air_is_stable() const { return air_.verdict().stable; }
  void judge_air(const calib::StabilityCriterion& criterion) { air_ = calib::StabilityJudge(criterion); }

  /// What the chamber was told to hold; nothing while it may do as it likes.
  void expect(const std::optional<double>& set_point_c) {
    expected_c_ = set_point_c;
    disobeyed_ = 0;
  }
  [[nodiscard]] const std::optional<double>& expected_c() const { return expected_c_; }
  /// Three readings in a row say another set point, or that control is off: the controller restarted, or someone
  /// pressed its keys.
  [[nodiscard]] bool disobeys() const;

  [[nodiscard]] hal::Chamber& chamber() { return chamber_; }
  [[nodiscard]] const hal::Chamber& chamber() const { return chamber_; }

 private:
  hal::Chamber& chamber_;
  double poll_s_;
  std::optional<double> polled_s_;
  std::chrono::steady_clock::time_point polled_host_{};
  std::chrono::steady_clock::time_point heard_host_{};
  std::optional<hal::ChamberReading> reading_;
  std::string trouble_;
  int misses_ = 0;
  std::optional<double> expected_c_;
  int disobeyed_ = 0;
  calib::StabilityJudge air_;
};

}  // namespace soak::station
