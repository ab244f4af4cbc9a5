// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "hal/maps/device_map.h"

namespace soak::hal {

/// Why a request failed.
struct LinkFault {
  std::string text;
  int exception = 0;  ///< code of a Modbus exception: the link is sound; 0 = the link was given up
};

template <class T>
using LinkAnswer = tl::expected<T, LinkFault>;
using LinkResult = LinkAnswer<void>;

/// A link to a controller. It never repairs itself within a call: a fault closes it, and open() refuses to try again
/// before a pause is over (after 1, 2, 5, then 10 s of host time, and never sooner than the response time-out). The
/// pause is also the quiet time in which a late answer runs out.
///
/// Requests belong to calls (begin_call()), and a call ends with a fault after five response time-outs: no request
/// takes longer than one, but a controller that answers each of many late could hold a caller.
class Link {
 public:
  using Clock = std::chrono::steady_clock;

  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  virtual ~Link() = default;

  [[nodiscard]] virtual bool is_open() const = 0;
  /// From here on the requests of another call are counted.
  void begin_call();
  /// Opens a closed link. During a pause it fails at once and says when the next try is.
  [[nodiscard]] LinkResult open();
  /// Says that the peer is the right one: the next pause is again the shortest.
  void confirm() { failures_ = 0; }
  /// Closes the link because of `reason` and begins a pause.
  void give_up(std::string reason);
  /// When a closed link may be opened again.
  [[nodiscard]] Clock::time_point next_try() const { return next_try_; }
  /// "host:port" or the serial device.
  [[nodiscard]] std::string address() const { return text_of(settings_.address); }

 protected:
  explicit Link(LinkSettings settings) : settings_(std::move(settings)) {}

  [[nodiscard]] const LinkSettings& settings() const { return settings_; }
  /// Whether another request may be made: the link is open and the present call not over.
  [[nodiscard]] LinkResult may_request();
  /// Opens what is closed; the fault's text says why it failed.
  [[nodiscard]] virtual LinkResult open_port() = 0;
  virtual void close_port() = 0;
  /// Whether the link may be opened or used from here.
  [[nodiscard]] virtual LinkResult check_use() { return {}; }

  [[nodiscard]] tl::unexpected<LinkFault> last_fault() const { return tl::unexpected(LinkFault{last_fault_}); }

 private:
  LinkSettings settings_;
  int failures_ = 0;
  std::string last_fault_ = "not connected";
  Clock::time_point next_try_{};
  Clock::time_point call_end_ = Clock::time_point::max();
};

/// Seconds as a span of the steady clock.
[[nodiscard]] inline Link::Clock::duration clock_time(double time_s) {
  return std::chrono::duration_cast<Link::Clock::duration>(std::chrono::duration<double>(time_s));
}

}  // namespace soak::hal
