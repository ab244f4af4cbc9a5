// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "hal/links/detail/link.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// Why a request failed.
struct LinkFault {
  std::string text;
  int exception = 0;  ///< code of a Modbus exception: the link is sound; 0 = the link was given up
};

using LinkResult = tl::expected<void, LinkFault>;

/// Pause before each request: the map's, else 30 ms on a serial line and none over TCP.
[[nodiscard]] double request_gap_s(const ModbusLinkSettings& settings);

/// A Modbus link over TCP or a serial line, on libmodbus. It never repairs itself within a call: a fault other than a
/// Modbus exception closes it, and open() refuses to try again before a pause is over (LinkPatience). Requests belong
/// to calls (begin_call()), and a call ends with a fault after five response time-outs.
///
/// libmodbus is not made for threads, and an answer on a serial line does not say whose it is: the link belongs to the
/// thread that first opens it. Requests of another one fail (and leave the link as it is).
class ModbusLink {
 public:
  explicit ModbusLink(ModbusLinkSettings settings);
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;
  ~ModbusLink();

  [[nodiscard]] bool is_open() const { return port_ != nullptr; }
  /// From here on the requests of another call are counted.
  void begin_call() { patience_.begin_call(); }
  /// Opens a closed link. During a pause it fails at once and says when the next try is.
  [[nodiscard]] LinkResult open();
  /// Says that the peer is the right one: the next pause is again the shortest.
  void confirm() { patience_.confirm(); }
  /// Closes the link because of `reason` and begins a pause.
  void give_up(std::string reason);

  /// Reads registers of an open link by function 3 or 4. A busy controller (exceptions 5 and 6) is asked again a few
  /// times.
  [[nodiscard]] LinkResult read(int function, int address, std::span<std::uint16_t> words);
  /// Writes registers by function 6 (one) or 16.
  [[nodiscard]] LinkResult write(int function, int address, std::span<const std::uint16_t> words);

  /// When a closed link may be opened again.
  [[nodiscard]] LinkPatience::Clock::time_point next_try() const { return patience_.next_try(); }

  /// "host:port" or the serial device.
  [[nodiscard]] std::string address() const;

 private:
  struct Port;
  using Clock = LinkPatience::Clock;

  [[nodiscard]] LinkResult exchange(int count, const std::function<int()>& request);
  [[nodiscard]] LinkFault fault_of(int code);
  [[nodiscard]] bool is_foreign_thread();

  ModbusLinkSettings settings_;
  std::unique_ptr<Port> port_;
  LinkPatience patience_;
  Clock::time_point last_request_{};
  std::thread::id owner_;
};

}  // namespace soak::hal
