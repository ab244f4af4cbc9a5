// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "base/file_descriptor.h"

namespace soak::station {

/// The service manager that started this program and waits for word of it, by the datagrams of sd_notify(3): systemd
/// with Type=notify, or any other that sets $NOTIFY_SOCKET. Where none did, every call does nothing. What cannot be
/// sent is lost without an error: the program goes on, and the manager draws its own conclusions. Calls may come from
/// several threads, still_alive() from one.
class ServiceManager {
 public:
  /// Reads $NOTIFY_SOCKET, $WATCHDOG_USEC and $WATCHDOG_PID.
  ServiceManager();

  /// The program serves; `status`: one line for `systemctl status`.
  void ready(std::string_view status) const;
  /// The program has been asked to end and is about to.
  void stopping(std::string_view status) const;
  /// The loop that matters has turned. Sent four times per period of the watchdog, however often it is called; never
  /// where the manager watches no process or another one.
  void still_alive();

 private:
  void send(const std::string& message) const;

  base::FileDescriptor socket_;
  std::string address_;  ///< of the manager; begins with a zero byte where it is an abstract one
  std::optional<std::chrono::microseconds> ping_every_;
  std::chrono::steady_clock::time_point next_ping_{};
};

}  // namespace soak::station
