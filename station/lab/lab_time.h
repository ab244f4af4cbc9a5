// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

namespace soak::station {

/// Time of the process, in seconds since the lab was opened: it follows the units' device time while any unit streams,
/// else the host's clock times `clock.rate`. Dwell, time-outs of the process and polling count it; link time-outs never
/// do.
class LabTime {
 public:
  explicit LabTime(double clock_rate) : rate_(clock_rate) {}

  [[nodiscard]] double now_s() const { return now_s_; }

  /// Moves on. `furthest_s`: where the streaming unit that is furthest ahead stands (UnitTime); absent where no unit
  /// streams.
  void advance(std::chrono::steady_clock::time_point host_now, const std::optional<double>& furthest_s) {
    const std::chrono::duration<double> host_advance =
        started_ ? host_now - host_last_ : std::chrono::duration<double>{0};
    now_s_ = furthest_s ? std::max(now_s_, *furthest_s) : now_s_ + host_advance.count() * rate_;
    host_last_ = host_now;
    started_ = true;
  }

 private:
  double rate_;
  double now_s_ = 0.0;
  bool started_ = false;
  std::chrono::steady_clock::time_point host_last_;
};

/// Where one unit's clock stands on the process' time. Units reach us one by one: each is followed by itself, or ten of
/// them would make time go ten times too fast.
class UnitTime {
 public:
  /// The unit's clock went on by `advance_s`; `began_anew`: it restarted. The first time it is put at `now_s`.
  double follow(double now_s, bool began_anew, double advance_s) {
    if (began_anew || !at_s_) at_s_ = now_s;
    return *at_s_ += advance_s;
  }
  /// The unit does not stream: its clock is unknown until it does again.
  void lose() { at_s_.reset(); }

 private:
  std::optional<double> at_s_;
};

}  // namespace soak::station
