// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "hal/links/detail/link.h"

namespace soak::hal {

/// Pause before each request: the map's, else 30 ms on a serial line and none over TCP.
[[nodiscard]] double request_gap_s(const LinkSettings& settings);

/// A Modbus link over TCP or a serial line, on libmodbus. A Modbus exception leaves it open, any other fault closes it.
///
/// libmodbus is not made for threads, and an answer on a serial line does not say whose it is: the link belongs to the
/// thread that first opens it. Requests of another one fail (and leave the link as it is).
class ModbusLink final : public Link {
 public:
  explicit ModbusLink(LinkSettings settings);
  ~ModbusLink() override;

  [[nodiscard]] bool is_open() const override { return port_ != nullptr; }

  /// Reads registers of an open link by function 3 or 4. A busy controller (exceptions 5 and 6) is asked again a few
  /// times, one whose answer is spoilt or that reports a failure of its own (exception 4) twice.
  [[nodiscard]] LinkResult read(int function, int address, std::span<std::uint16_t> words);
  /// Writes registers by function 6 (one) or 16.
  [[nodiscard]] LinkResult write(int function, int address, std::span<const std::uint16_t> words);

 private:
  struct Port;

  [[nodiscard]] LinkResult open_port() override;
  void close_port() override;
  [[nodiscard]] LinkResult check_use() override;
  [[nodiscard]] LinkResult exchange(int count, const std::function<int()>& request);
  [[nodiscard]] LinkFault fault_of(int code);

  std::unique_ptr<Port> port_;
  Clock::time_point last_request_{};
  std::thread::id owner_;
};

}  // namespace soak::hal
