// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace soak::hal {

/// When a link that was given up may be tried again (after 1, 2, 5, then 10 s of host time, and never sooner than the
/// response time-out), and when a call has lasted long enough: no request takes longer than the response time-out, but
/// a controller that answers each of many late could hold a caller. The pause is also the quiet time in which a late
/// answer runs out.
class LinkPatience {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LinkPatience(double response_timeout_s) : response_timeout_s_(response_timeout_s) {}

  /// From here on the requests of another call are counted: it may last five response time-outs.
  void begin_call();
  [[nodiscard]] bool call_is_over() const { return Clock::now() >= call_end_; }

  /// Why the link may not be tried yet, with the time that is left; nothing = it may.
  [[nodiscard]] std::optional<std::string> must_wait() const;
  /// Begins a pause.
  void give_up(std::string reason);
  /// The peer is the right one: the next pause is again the shortest.
  void confirm() { failures_ = 0; }
  [[nodiscard]] const std::string& last_fault() const { return last_fault_; }
  [[nodiscard]] Clock::time_point next_try() const { return next_try_; }

 private:
  double response_timeout_s_;
  int failures_ = 0;
  std::string last_fault_ = "not connected";
  Clock::time_point next_try_{};
  Clock::time_point call_end_ = Clock::time_point::max();
};

/// Seconds as a span of the steady clock.
[[nodiscard]] inline LinkPatience::Clock::duration clock_time(double time_s) {
  return std::chrono::duration_cast<LinkPatience::Clock::duration>(std::chrono::duration<double>(time_s));
}

}  // namespace soak::hal
