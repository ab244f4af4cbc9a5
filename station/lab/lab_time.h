// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace soak::station {

/// Time of the process, in seconds since the lab was opened: it follows the units' device time while any unit streams,
/// else the host's clock times `clock.rate`. Dwell, time-outs of the process and polling count it; link time-outs never
/// do.
class LabTime {
 public:
  explicit LabTime(double clock_rate) : rate_(clock_rate) {}

  [[nodiscard]] double now_s() const { return now_s_; }

  /// Moves on. `device_advance_s`: how far the streaming units' own clocks went since the last call; `streaming`:
  /// whether there is such a unit at all.
  void advance(std::chrono::steady_clock::time_point host_now, bool streaming, double device_advance_s) {
    const std::chrono::duration<double> host_advance =
        started_ ? host_now - host_last_ : std::chrono::duration<double>{0};
    now_s_ += streaming ? device_advance_s : host_advance.count() * rate_;
    host_last_ = host_now;
    started_ = true;
  }

 private:
  double rate_;
  double now_s_ = 0.0;
  bool started_ = false;
  std::chrono::steady_clock::time_point host_last_;
};

}  // namespace soak::station
